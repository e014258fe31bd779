#include "server/auth/authorization.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

namespace faultlab::server {
namespace {

/// The whole matrix, written independently a second time: for each operation the six roles guest,
/// student, instructor, operator, admin, service; letters n(one) o(wn) c(ourse) f(oreign).
const std::map<std::string, std::string> kExpected = {
    {"read_public", "nocf nocf nocf nocf nocf nocf"},
    {"list_rigs", "nocf nocf nocf nocf nocf nocf"},
    {"start_run", "no no no no no no"},
    {"read_run", "no no noc nocf nocf no"},
    {"change_run", "o o oc ocf ocf o"},
    {"delete_run", "o o o o ocf o"},
    {"upload_recording", "n n n n n n"},
    {"manage_own_account", "- no no no no -"},
    {"read_users", "- o oc nocf nocf -"},
    {"manage_users", "- - - - nocf -"},
    {"read_course", "- noc noc nocf nocf noc"},
    {"manage_course", "- - no - nocf -"},
    {"use_ticket", "- no no nocf nocf no"},
    {"use_booking", "- no no nocf nocf no"},
    {"use_session", "- no no nocf nocf no"},
    {"take_over_session", "- - c cf cf -"},
    {"spectate", "- no noc nocf nocf no"},
    {"submit_job", "- no no nocf nocf no"},
    {"read_fault_set", "- noc noc nocf nocf noc"},
    {"manage_fault_set", "- - no - nocf -"},
    {"operate_rig", "- - - nocf nocf -"},
    {"read_audit", "- - - nocf nocf -"},
    {"read_metrics", "nocf nocf nocf nocf nocf nocf"},
    {"manage_webhooks", "- - - - nocf -"},
    {"use_webhook", "- no no no no no"},
    {"manage_policy", "- - - - nocf -"},
};

TEST(Authorization, AllowsExactlyWhatTheWrittenMatrixSays) {
  int cases = 0;
  for (int o = 0; o < kOperationCount; ++o) {
    const auto operation = static_cast<Operation>(o);
    const auto expected = kExpected.find(std::string(Name(operation)));
    ASSERT_NE(expected, kExpected.end()) << Name(operation);
    std::string rest = expected->second + " ";
    for (int r = 0; r < kRoleCount; ++r) {
      const std::string letters = rest.substr(0, rest.find(' '));
      rest.erase(0, rest.find(' ') + 1);
      for (int w = 0; w < kOwnershipCount; ++w) {
        const bool allowed = letters.find("nocf"[w]) != std::string::npos;
        EXPECT_EQ(Allowed(static_cast<Role>(r), operation, static_cast<Ownership>(w)), allowed)
            << Name(operation) << " role " << Name(static_cast<Role>(r)) << " ownership " << w;
        ++cases;
      }
    }
  }
  EXPECT_EQ(cases, kOperationCount * kRoleCount * kOwnershipCount);
  EXPECT_EQ(kExpected.size(), static_cast<std::size_t>(kOperationCount));
}

Principal Person(Role role) {
  Principal principal;
  principal.user_id = role == Role::kGuest ? 0 : 7;
  principal.role = role;
  principal.proof = role == Role::kGuest ? Proof::kNone : Proof::kSessionCookie;
  return principal;
}

TEST(Authorization, TellsGuestsToSignInAndHidesForeignObjects) {
  using core::ErrorCode;
  const auto code = [](Role role, Operation operation, Ownership ownership) {
    return Authorize(Person(role), operation, ownership).error().code;
  };
  EXPECT_EQ(code(Role::kGuest, Operation::kUseTicket, Ownership::kNone), ErrorCode::kUnauthorized);
  EXPECT_EQ(code(Role::kStudent, Operation::kReadRun, Ownership::kForeign), ErrorCode::kNotFound);
  EXPECT_EQ(code(Role::kStudent, Operation::kDeleteRun, Ownership::kForeign), ErrorCode::kNotFound);
  EXPECT_EQ(code(Role::kInstructor, Operation::kDeleteRun, Ownership::kCourse),
            ErrorCode::kForbidden)
      << "may read it, so may know of it";
  EXPECT_EQ(code(Role::kStudent, Operation::kOperateRig, Ownership::kNone), ErrorCode::kForbidden);
}

TEST(Authorization, AnApiKeyNeedsTheScopeOfTheOperation) {
  Principal key = Person(Role::kService);
  key.proof = Proof::kApiKey;
  key.scopes = {"runs:read"};
  EXPECT_TRUE(Authorize(key, Operation::kReadRun, Ownership::kOwn).ok());
  EXPECT_EQ(Authorize(key, Operation::kStartRun, Ownership::kNone).error().code,
            core::ErrorCode::kForbidden);
  key.scopes = {"runs:write"};
  EXPECT_TRUE(Authorize(key, Operation::kStartRun, Ownership::kNone).ok());
  EXPECT_FALSE(Authorize(key, Operation::kReadRun, Ownership::kOwn).ok());
}

Principal KeyOf(Role role, const std::string& scope) {
  Principal key = Person(Role::kService);
  key.proof = Proof::kApiKey;
  key.account_role = role;
  key.scopes = {scope};
  return key;
}

TEST(Authorization, AStaffScopeLendsTheRoleOfTheAccountForItsOperationsAlone) {
  const auto may = [](Role role, const std::string& scope, Operation operation) {
    return Authorize(KeyOf(role, scope), operation, Ownership::kNone).ok();
  };
  EXPECT_TRUE(may(Role::kOperator, "operate", Operation::kOperateRig));
  EXPECT_TRUE(may(Role::kAdmin, "people", Operation::kManageUsers));
  EXPECT_TRUE(may(Role::kInstructor, "courses", Operation::kManageCourse));
  EXPECT_TRUE(may(Role::kOperator, "audit", Operation::kReadAudit));
  EXPECT_FALSE(may(Role::kAdmin, "operate", Operation::kManageUsers));
  EXPECT_FALSE(may(Role::kAdmin, "people", Operation::kOperateRig));
  EXPECT_FALSE(may(Role::kStudent, "operate", Operation::kOperateRig)) << "no longer an operator";
  EXPECT_FALSE(may(Role::kOperator, "people", Operation::kManageUsers));
  EXPECT_FALSE(may(Role::kAdmin, "people", Operation::kManageOwnAccount)) << "keys make no keys";
  EXPECT_EQ(Authorize(KeyOf(Role::kAdmin, "jobs"), Operation::kOperateRig, Ownership::kNone)
                .error()
                .reason,
            "scope_lacking");
  // The runs of others stay closed to a key, whoever has made it.
  EXPECT_FALSE(
      Authorize(KeyOf(Role::kAdmin, "runs:read"), Operation::kReadRun, Ownership::kForeign).ok());
  const auto course = Ownership::kCourse;
  EXPECT_TRUE(Authorize(KeyOf(Role::kInstructor, "runs:read"), Operation::kReadRun, course).ok());
  EXPECT_TRUE(Authorize(KeyOf(Role::kInstructor, "runs:read"), Operation::kSpectate, course).ok());
  EXPECT_FALSE(Authorize(KeyOf(Role::kInstructor, "jobs"), Operation::kReadRun, course).ok());
  EXPECT_FALSE(
      Authorize(KeyOf(Role::kInstructor, "runs:write"), Operation::kChangeRun, course).ok());
  EXPECT_FALSE(Authorize(KeyOf(Role::kStudent, "runs:read"), Operation::kReadRun, course).ok());
}

TEST(Authorization, AScopeIsGivenByThoseWhoseRoleCanUseIt) {
  for (const std::string_view scope : kScopes) {
    EXPECT_TRUE(MayHaveScope(Role::kAdmin, scope)) << scope;
  }
  for (const std::string_view scope : {"runs:read", "runs:write", "jobs", "lab"}) {
    EXPECT_TRUE(MayHaveScope(Role::kStudent, scope)) << scope;
  }
  for (const std::string_view scope : {"operate", "people", "courses", "audit"}) {
    EXPECT_FALSE(MayHaveScope(Role::kStudent, scope)) << scope;
  }
  EXPECT_TRUE(MayHaveScope(Role::kInstructor, "courses"));
  EXPECT_FALSE(MayHaveScope(Role::kInstructor, "people"));
  EXPECT_TRUE(MayHaveScope(Role::kOperator, "people"));
  EXPECT_FALSE(MayHaveScope(Role::kOperator, "courses"));
  EXPECT_FALSE(MayHaveScope(Role::kAdmin, "root"));
}

}  // namespace
}  // namespace faultlab::server
