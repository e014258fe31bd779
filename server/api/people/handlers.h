#pragma once

#include <boost/json/object.hpp>

#include "server/api/gate.h"
#include "server/auth/accounts.h"
#include "server/auth/audit_log.h"

// Sign-in, accounts, API keys, courses, audit log.
namespace faultlab::server {

struct PeopleApi {
  Accounts& accounts;
  AuditLog& audit;
  const Clock& clock;
};

std::vector<ApiRoute> RoutesOf(PeopleApi& api);

// sign_in.cc
/// HttpOnly, of the whole site, Secure where the browser came by https; age 0 ends it.
void SetCookie(const ApiRequest& request,
               std::string_view name,
               const std::string& value,
               int age_s,
               HttpResponse& response);
/// Of the sign-in and of the browser.
void AddSignInCookies(const ApiRequest& request, const SignedIn& signed_in, HttpResponse& response);
core::Result<HttpResponse> SignIn(PeopleApi& api, const ApiRequest& request);
core::Result<HttpResponse> SignOut(PeopleApi& api, const ApiRequest& request);
core::Result<HttpResponse> ChangePassword(PeopleApi& api, const ApiRequest& request);
core::Result<HttpResponse> UseResetLink(PeopleApi& api, const ApiRequest& request);
core::Result<HttpResponse> ListApiKeys(PeopleApi& api, const ApiRequest& request);
core::Result<HttpResponse> CreateApiKey(PeopleApi& api, const ApiRequest& request);
core::Result<HttpResponse> RevokeApiKey(PeopleApi& api, const ApiRequest& request);

// people.cc
core::Result<HttpResponse> ListUsers(PeopleApi& api, const ApiRequest& request);
core::Result<HttpResponse> CreateUser(PeopleApi& api, const ApiRequest& request);
core::Result<HttpResponse> ChangeUser(PeopleApi& api, const ApiRequest& request);
core::Result<HttpResponse> CreateResetLink(PeopleApi& api, const ApiRequest& request);
core::Result<HttpResponse> ListAuditLog(PeopleApi& api, const ApiRequest& request);
boost::json::object UserToJson(const Account& account);

// courses.cc
core::Result<HttpResponse> ListCourses(PeopleApi& api, const ApiRequest& request);
core::Result<HttpResponse> CreateCourse(PeopleApi& api, const ApiRequest& request);
core::Result<HttpResponse> SetCourseEnd(PeopleApi& api, const ApiRequest& request);
core::Result<HttpResponse> ListMembers(PeopleApi& api, const ApiRequest& request);
core::Result<HttpResponse> EnrolMembers(PeopleApi& api, const ApiRequest& request);
core::Result<HttpResponse> EndEnrolment(PeopleApi& api, const ApiRequest& request);
core::Result<HttpResponse> ListCourseInvitations(PeopleApi& api, const ApiRequest& request);
core::Result<HttpResponse> ListInvitations(PeopleApi& api, const ApiRequest& request);
core::Result<HttpResponse> AcceptInvitation(PeopleApi& api, const ApiRequest& request);
core::Result<HttpResponse> DeclineInvitation(PeopleApi& api, const ApiRequest& request);
}  // namespace faultlab::server
