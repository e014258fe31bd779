#include "server/api/people/handlers.h"

namespace faultlab::server {

std::vector<ApiRoute> RoutesOf(PeopleApi& api) {
  using enum HttpMethod;
  using enum Operation;
  using enum Guard;
  using enum Cost;
  const auto on = [&api](auto handler) { return On(api, handler); };
  return {
      {kPost, "/api/v1/auth/login", kReadPublic, kAnybody, on(SignIn), kSignInJson, kPassword},
      {kPost,
       "/api/v1/auth/reset",
       kReadPublic,
       kAnybody,
       on(UseResetLink),
       kSignInJson,
       kPassword},
      {kPost, "/api/v1/auth/logout", kManageOwnAccount, kRole, on(SignOut), kEmpty},
      {kPost,
       "/api/v1/auth/password",
       kManageOwnAccount,
       kRole,
       on(ChangePassword),
       kJson,
       kPassword},
      {kGet, "/api/v1/api-keys", kManageOwnAccount, kRole, on(ListApiKeys)},
      {kPost, "/api/v1/api-keys", kManageOwnAccount, kRole, on(CreateApiKey), kJson},
      {kDelete, "/api/v1/api-keys/{id}", kManageOwnAccount, kRole, on(RevokeApiKey)},
      {kGet, "/api/v1/users", kReadUsers, kRole, on(ListUsers)},
      {kPost, "/api/v1/users", kManageUsers, kRole, on(CreateUser), kJsonOnce},
      {kPatch, "/api/v1/users/{id}", kManageUsers, kRole, on(ChangeUser), kJson},
      {kPost, "/api/v1/users/{id}/reset-link", kManageUsers, kRole, on(CreateResetLink), kEmpty},
      {kGet, "/api/v1/courses", kReadCourse, kRole, on(ListCourses)},
      {kPost, "/api/v1/courses", kManageCourse, kRole, on(CreateCourse), kJsonOnce},
      {kPut, "/api/v1/courses/{id}/end", kReadCourse, kRole, on(SetCourseEnd), kJson},
      {kGet, "/api/v1/courses/{id}/members", kReadCourse, kRole, on(ListMembers)},
      {kPost,
       "/api/v1/courses/{id}/members",
       kReadCourse,
       kRole,
       on(EnrolMembers),
       kClassList,
       kHeavy},
      {kDelete, "/api/v1/courses/{id}/members/{user}", kReadCourse, kRole, on(EndEnrolment)},
      {kGet, "/api/v1/courses/{id}/invitations", kReadCourse, kRole, on(ListCourseInvitations)},
      {kGet, "/api/v1/invitations", kManageOwnAccount, kRole, on(ListInvitations)},
      {kPost,
       "/api/v1/invitations/{course}/accept",
       kManageOwnAccount,
       kRole,
       on(AcceptInvitation),
       kEmpty},
      {kPost,
       "/api/v1/invitations/{course}/decline",
       kManageOwnAccount,
       kRole,
       on(DeclineInvitation),
       kEmpty},
      {kGet, "/api/v1/audit", kReadAudit, kRole, on(ListAuditLog)},
  };
}

}  // namespace faultlab::server
