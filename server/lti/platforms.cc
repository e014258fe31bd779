#include "server/lti/platforms.h"

#include <boost/json.hpp>
#include <charconv>

#include "server/storage/rows.h"
#include "server/storage/turns.h"

namespace faultlab::server::lti {

template <typename Visit>
void Fields(Platform& platform, Visit&& visit) {
  visit("id", platform.id);
  visit("label", platform.label);
  visit("issuer", platform.issuer);
  visit("client_id", platform.client_id);
  visit("deployment", platform.deployment);
  visit("auth_url", platform.auth_url);
  visit("token_url", platform.token_url);
  visit("keys_url", platform.keys_url);
  visit("makes_teachers", platform.makes_teachers);
  visit("claims_class_lists", platform.claims_class_lists);
  visit("created_ms", platform.created);
}

namespace {

constexpr std::string_view kPrefix = "lti:";

struct SentRow {
  std::string about;
  Platforms::Sent sent;
};

template <typename Visit>
void Fields(SentRow& row, Visit&& visit) {
  visit("about", row.about);
  visit("account_id", row.sent.account);
  visit("created_ms", row.sent.at);
  visit("state", row.sent.state);
  visit("attempts", row.sent.attempts);
  visit("error", row.sent.error);
}

core::Status RoomIn(Transaction& tx) {
  if (CountRows(tx, "lti_platform") < Platforms::kMax) return core::Done{};
  return core::Refuse("platforms_full", "", {{"most", Platforms::kMax}});
}

/// No other platform is this client of this issuer.
core::Status CheckNew(Transaction& tx, const Platform& platform) {
  const std::int64_t others =
      CountRows(tx,
                "lti_platform WHERE issuer = :issuer AND client_id = :client AND id <> :id",
                {{"issuer", platform.issuer}, {"client", platform.client_id}, {"id", platform.id}});
  return others == 0 ? core::Status(core::Done{}) : core::Refuse("platform_known", "/client_id");
}

}  // namespace

std::string NameOf(std::int64_t platform) {
  return std::string(kPrefix) + std::to_string(platform);
}

std::optional<std::int64_t> PlatformOf(std::string_view name) {
  if (!name.starts_with(kPrefix)) return std::nullopt;
  name.remove_prefix(kPrefix.size());
  std::int64_t id = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), id);
  if (error != std::errc{} || end != name.data() + name.size()) return std::nullopt;
  return id;
}

core::Result<Platform> Platforms::Add(Platform platform) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Platform> {
    TakeTurn(tx, "lti_platforms");
    TRY_DONE(RoomIn(tx));
    TRY_DONE(CheckNew(tx, platform));
    platform.id = AddRow(tx, "lti_platform", platform);
    return platform;
  });
}

core::Status Platforms::CheckRoom() {
  return database_.Read([](Transaction& tx) { return RoomIn(tx); });
}

core::Result<Platform> Platforms::Put(Platform platform) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Platform> {
    TakeTurn(tx, "lti_platforms");
    const auto before =
        SelectRow<Platform>(tx, "lti_platform WHERE id = :id", {{"id", platform.id}});
    if (!before) return core::Refuse("no_platform");
    TRY_DONE(CheckNew(tx, platform));
    // Somebody else has the same number elsewhere.
    const bool known =
        CountRows(
            tx, "external_identity WHERE issuer = :issuer", {{"issuer", NameOf(platform.id)}}) > 0;
    if (known && platform.issuer != before->issuer) {
      return core::Refuse("platform_issuer_stays", "/issuer");
    }
    // They come back with the next launch; a token goes to nobody but who is asked for it.
    if (platform.token_url != before->token_url) {
      DeleteFrom(tx, "lti_roster", {{"platform_id", platform.id}});
    }
    platform.created = before->created;
    ChangeRows(tx, "lti_platform", platform, {}, "id = :id");
    return platform;
  });
}

core::Result<std::vector<Platform>> Platforms::List() {
  return database_.Read(
      [](Transaction& tx) { return SelectRows<Platform>(tx, "lti_platform ORDER BY id"); });
}

core::Result<Platform> Platforms::Get(std::int64_t id) {
  return database_.Read([&](Transaction& tx) -> core::Result<Platform> {
    auto found = SelectRow<Platform>(tx, "lti_platform WHERE id = :id", {{"id", id}});
    if (!found) return core::Refuse("no_platform");
    return std::move(*found);
  });
}

core::Result<Platform> Platforms::Find(const std::string& issuer, const std::string& client_id) {
  return database_.Read([&](Transaction& tx) -> core::Result<Platform> {
    auto found = SelectRows<Platform>(
        tx,
        "lti_platform WHERE issuer = :issuer AND (client_id = :client OR :client = '')",
        {{"issuer", issuer}, {"client", client_id}});
    if (found.size() != 1) return core::Refuse("no_platform");
    return std::move(found.front());
  });
}

core::Status Platforms::Remove(std::int64_t id) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (DeleteFrom(tx, "lti_platform", {{"id", id}}) == 0) return core::Refuse("no_platform");
    DeleteFrom(tx, "lti_seat", {{"platform_id", id}});
    DeleteFrom(tx, "lti_roster", {{"platform_id", id}});
    DeleteFrom(tx, "outbox", {{"channel", NameOf(id)}});
    return core::Done{};
  });
}

core::Result<std::vector<Platforms::Sent>> Platforms::SentTo(std::int64_t id, int limit) {
  return database_.Read([&](Transaction& tx) -> core::Result<std::vector<Sent>> {
    std::vector<Sent> list;
    for (SentRow& row : SelectRows<SentRow>(
             tx,
             "outbox WHERE channel = :channel ORDER BY id DESC LIMIT " + std::to_string(limit),
             {{"channel", NameOf(id)}})) {
      const boost::json::value about = boost::json::parse(row.about);
      row.sent.assignment = about.at("assignment").to_number<std::int64_t>();
      list.push_back(std::move(row.sent));
    }
    return list;
  });
}

}  // namespace faultlab::server::lti
