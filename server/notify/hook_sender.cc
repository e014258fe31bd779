#include "server/notify/hook_sender.h"

#include "server/notify/signature.h"

namespace faultlab::server::notify {
namespace {

using Outcome = Attempt::Outcome;
using std::chrono::seconds;

constexpr std::size_t kUrlMax = 2000;
/// Receivers answer at once and work afterwards.
constexpr seconds kPatience{5};
constexpr std::size_t kAnswerMax = 64 << 10;

std::string BodyOf(const Message& message) {
  return R"({"type":")" + message.kind + R"(","timestamp":")" + Stamp(message.created) +
         R"(","data":)" + message.about + "}";
}

Outcome OutcomeOf(int status) {
  if (status >= 200 && status < 300) return Outcome::kTaken;
  const bool overloaded = status == 408 || status == 425 || status == 429 || status >= 500;
  return overloaded ? Outcome::kNotNow : Outcome::kRefused;
}

}  // namespace

HookSender::HookSender(bool insecure_local, const std::string& ca_file)
    : local_for_all_(insecure_local),
      client_({.ca_file = ca_file,
               .insecure_local = insecure_local,
               .deadline = kPatience,
               .bytes_max = kAnswerMax}) {}

core::Status HookSender::CheckUrl(const std::string& url) const {
  const bool printable = url.find_first_of(" \t\r\n") == std::string::npos;
  if (url.size() <= kUrlMax && printable && client_.CheckUrl(url).ok()) return core::Done{};
  return core::Refuse("webhook_url_wrong", "/url");
}

Attempt HookSender::Send(const Webhook& hook, const Message& message, WallTime now) const {
  const std::string body = BodyOf(message);
  const std::string at =
      std::to_string(std::chrono::floor<seconds>(now).time_since_epoch().count());
  WebRequest request;
  request.url = hook.url;
  request.headers = {"Content-Type: application/json",
                     "Accept: */*",
                     "webhook-id: " + message.delivery,
                     "webhook-timestamp: " + at,
                     "webhook-signature: " + Sign(hook.secret, message.delivery, at, body),
                     "X-Faultlab-Delivery: " + message.delivery};
  request.body = body;
  request.public_only = hook.account != 0 && !local_for_all_;
  const auto answer = client_.Ask(request);
  if (!answer.ok()) {
    // A receiver whose answer is too large has taken the message.
    if (answer.error().code == core::ErrorCode::kTooLarge) return {};
    return {Outcome::kNotNow, answer.error().message};
  }
  const int status = answer.value().status;
  const Outcome outcome = OutcomeOf(status);
  if (outcome == Outcome::kTaken) return {};
  return {outcome, "the answer was " + std::to_string(status)};
}

}  // namespace faultlab::server::notify
