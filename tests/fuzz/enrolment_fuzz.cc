// A list of students, as far as it is read without a course: read completely, or refused with the
// line.
#include <filesystem>

#include "server/auth/accounts.h"
#include "server/storage/database.h"
#include "tests/fuzz/fuzz_input.h"

using namespace faultlab;  // NOLINT(google-build-using-namespace)
using fuzz::Require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string kFile = (std::filesystem::temp_directory_path() /
                                    ("fuzz_enrolment_" + std::to_string(getpid()) + ".db"))
                                       .string();
  static const std::unique_ptr<server::Database> kDatabase =
      server::Database::Open({.location = kFile}).value();
  static server::Accounts accounts(*kDatabase, server::GuestAccess::kNever);
  server::Principal who;
  who.user_id = 1;
  who.role = server::Role::kInstructor;
  const auto done = accounts.EnrolCsv(who, 77, fuzz::Text(data, size), server::WallTime{});
  Require(!done.ok() && !done.error().message.empty());
  return 0;
}
