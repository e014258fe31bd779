#include "server/cli/person_data.h"

#include <sys/stat.h>

#include <boost/json.hpp>
#include <chrono>
#include <filesystem>

#include "server/auth/accounts.h"
#include "server/cli/console.h"
#include "server/csv/csv_writer.h"
#include "server/csv/file_io.h"
#include "server/privacy/person_data.h"
#include "server/storage/picture_store.h"
#include "server/storage/recording_store.h"

namespace faultlab::server {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;

json::object ToJson(const std::vector<PersonTable>& tables) {
  json::object out;
  for (const PersonTable& table : tables) {
    json::array rows;
    for (const std::vector<std::string>& row : table.rows) {
      json::object one;
      for (std::size_t i = 0; i < row.size(); ++i) one[table.columns[i]] = row[i];
      rows.push_back(std::move(one));
    }
    out[table.name] = std::move(rows);
  }
  return out;
}

core::Status WritePictures(Database& database, const std::string& run, const fs::path& folder) {
  PictureStore store(database);
  TRY(const auto pictures, store.List(run));
  for (const StoredPicture& picture : pictures) {
    TRY(const auto bytes, store.Load(run, picture.index));
    const std::string ending = picture.content_type == "image/png" ? ".png" : ".jpg";
    const std::string name = run + "-" + std::to_string(picture.index) + ending;
    TRY_DONE(WriteFile((folder / name).string(), bytes));
  }
  return core::Done{};
}

core::Status WriteAll(Database& database, std::int64_t account_id, const fs::path& folder) {
  TRY(const auto tables, PersonData(database, account_id));
  TRY_DONE(WriteFile((folder / "person.json").string(), json::serialize(ToJson(tables)) + "\n"));
  TRY(const auto recordings, RecordingsOf(database, account_id));
  RecordingStore store(database);
  for (const std::string& id : recordings) {
    TRY(const auto samples, store.LoadSamples(id));
    TRY_DONE(WriteCsv((folder / (id + ".csv")).string(), samples));
    TRY_DONE(WritePictures(database, id, folder));
  }
  return core::Done{};
}

core::Result<Account> AccountOf(Database& database, const std::string& login) {
  return Accounts(database, GuestAccess::kNever).GetByLogin(login);
}

}  // namespace

int RunPersonExport(const PersonOptions& options) {
  umask(077);
  const auto database = OpenExisting(options.target);
  if (!database) return Fail(database.error());
  const auto account = AccountOf(*database.value(), options.login);
  if (!account) return Fail(account.error());
  std::error_code ec;
  const fs::path folder(options.folder);
  if (fs::exists(folder, ec)) {
    PrintError(options.folder + " exists; name a new folder");
    return kExitBadInput;
  }
  fs::create_directories(folder, ec);
  if (!ec) fs::permissions(folder, fs::perms::owner_all, ec);  // protects all files in it
  if (ec) {
    PrintError("cannot make " + options.folder + ": " + ec.message());
    return kExitFailure;
  }
  const core::Status written = WriteAll(*database.value(), account.value().id, folder);
  if (!written.ok()) return Fail(written.error());
  return Print("what is kept of " + account.value().login + " is in " + options.folder + "\n");
}

int RunPersonErase(const PersonOptions& options) {
  const auto database = OpenExisting(options.target);
  if (!database) return Fail(database.error());
  const auto account = AccountOf(*database.value(), options.login);
  if (!account) return Fail(account.error());
  if (!options.yes) {
    PrintError("this deletes the recordings, jobs and sign-ins of " + account.value().login +
               " for good; export them first, then say --yes");
    return kExitBadInput;
  }
  const auto now = std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
  const core::Status erased = ErasePerson(*database.value(), account.value().id, now);
  if (!erased.ok()) return Fail(erased.error());
  return Print(account.value().login + " is erased\n");
}

}  // namespace faultlab::server
