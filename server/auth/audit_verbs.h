#pragma once

#include <array>
#include <string_view>

namespace faultlab::server {

/// What the audit log tells of. A test of the page holds that every verb is in this list and has
/// its sentence.
inline constexpr std::array<std::string_view, 56> kAuditVerbs{
    "accept_invitation",
    "acknowledge",
    "add_identity",
    "adopt",
    "award_points",
    "bring_sealed",
    "change_assignment",
    "change_fault_set",
    "change_password",
    "change_platform",
    "change_policy",
    "change_user",
    "class_links",
    "clear_trip",
    "commission",
    "course_end",
    "create_assignment",
    "create_calendar_link",
    "create_course",
    "create_fault_set",
    "create_key",
    "create_platform",
    "create_user",
    "create_webhook",
    "decline_invitation",
    "delete_assignment",
    "delete_fault_set",
    "delete_platform",
    "delete_run",
    "delete_webhook",
    "end_enrolment",
    "end_session",
    "enrol",
    "erase_account",
    "extend_assignment",
    "invite",
    "mail_links",
    "outage",
    "quarantine",
    "release",
    "remove_calendar_link",
    "remove_identity",
    "remove_outage",
    "replace_relay",
    "reset_link",
    "retention",
    "revoke_key",
    "self_test",
    "sign_in",
    "sign_in_failed",
    "sign_in_throttled",
    "sign_out",
    "stop_run",
    "take_back",
    "take_over",
    "use_reset_link",
};

}  // namespace faultlab::server
