#pragma once

#include <boost/json/object.hpp>

#include "server/api/api.h"

// Sign-in, accounts, API keys, courses, audit log.
namespace faultlab::server {

// sign_in.cc
/// HttpOnly, of the whole site, Secure where the browser came by https; age 0 ends it.
void SetCookie(const ApiRequest& request,
               std::string_view name,
               const std::string& value,
               int age_s,
               HttpResponse& response);
/// Of the sign-in and of the browser.
void AddSignInCookies(const ApiRequest& request, const SignedIn& signed_in, HttpResponse& response);

// providers.cc
/// As browsers reach this server: "https://lab.example.org".
std::string BaseUrl(const Api& api, const ApiRequest& request);
/// Browsers ask this, not programs: they are sent on to a page.
HttpResponse GoTo(const std::string& location);

// courses.cc
/// The course of the path's {id}, if the caller teaches or runs it.
core::Result<std::int64_t> TaughtCourse(Api& api, const ApiRequest& request);

// rosters.cc
/// For somebody of a platform who is not known here.
NewcomerRules NewcomersOf(const lti::Platform& platform, const std::string& subject, bool teaches);

// people.cc
boost::json::object UserToJson(const Account& account);

}  // namespace faultlab::server
