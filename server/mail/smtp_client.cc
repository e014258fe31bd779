#include "server/mail/smtp_client.h"

#include <curl/curl.h>

#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "core/types/check.h"

namespace faultlab::server::mail {
namespace {

using notify::Attempt;
using Outcome = Attempt::Outcome;

constexpr long kConnectMs = 10'000;
constexpr long kDeadlineMs = 60'000;
constexpr std::string_view kSmtp = "smtp://";
constexpr std::string_view kSmtps = "smtps://";

struct FreeCurl {
  void operator()(CURL* curl) const { curl_easy_cleanup(curl); }
};
struct FreeList {
  void operator()(curl_slist* list) const { curl_slist_free_all(list); }
};
struct FreeMime {
  void operator()(curl_mime* mime) const { curl_mime_free(mime); }
};
using List = std::unique_ptr<curl_slist, FreeList>;

void Append(List& list, const std::string& line) {
  curl_slist* longer = curl_slist_append(list.get(), line.c_str());
  if (longer == nullptr) return;
  (void)list.release();
  list.reset(longer);
}

bool IsLoopback(std::string_view address) {
  const std::string_view host = address.substr(std::min(address.size(), kSmtp.size()));
  return host.starts_with("127.0.0.1:") || host == "127.0.0.1";
}

/// Keeps the last refusal of the server, "550 no such user"; a good-bye follows it.
std::size_t Hear(char* data, std::size_t size, std::size_t count, void* user) {
  std::string& said = *static_cast<std::string*>(user);
  std::string_view line(data, size * count);
  line = line.substr(0, line.find_last_not_of("\r\n") + 1);
  if (line.starts_with('4') || line.starts_with('5')) said = line;
  return size * count;
}

/// What became of a mail that was not taken.
Attempt Refused(CURLcode done, long code, const std::string& why, const std::string& said) {
  // One code of libcurl stands for all that a server refuses; its words say of what.
  const bool of_address = why.starts_with("RCPT failed");
  const bool of_sender = done == CURLE_LOGIN_DENIED || why.starts_with("MAIL failed");
  // Servers hold back until the address what they have against the sender.
  const bool policy =
      code == 504 || code == 553 || code == 554 || said.find(" 5.7.") != std::string::npos;
  const std::string words = code > 0 && !said.empty() ? said : why;
  if (of_address && code >= 500 && !policy) return {Outcome::kNever, words};
  if (of_address && code < 500) return {Outcome::kRefused, words};
  // It may have been taken: not again at once.
  const bool of_mail = !of_address && !of_sender && code >= 500;
  if (of_mail || done == CURLE_OPERATION_TIMEDOUT) return {Outcome::kRefused, words};
  return {Outcome::kNotNow, words};
}

}  // namespace

SmtpClient::SmtpClient(MailSettings settings) : settings_(std::move(settings)) {
  static const CURLcode started = curl_global_init(CURL_GLOBAL_DEFAULT);
  LAB_CHECK(started == CURLE_OK);
}

bool SmtpClient::IsServer(std::string_view url) {
  const bool known = url.starts_with(kSmtp) || url.starts_with(kSmtps);
  return known && url.find_first_of(" \t\r\n@") == std::string_view::npos;
}

Attempt SmtpClient::Send(const Letter& letter) const {
  const std::unique_ptr<CURL, FreeCurl> curl(curl_easy_init());
  if (!curl) return {Outcome::kNotNow, "no memory for a connection"};
  CURL* const to = curl.get();
  const std::unique_ptr<curl_mime, FreeMime> mime(curl_mime_init(to));
  if (!mime) return {Outcome::kNotNow, "no memory for a mail"};
  curl_mimepart* const part = curl_mime_addpart(mime.get());
  curl_mime_data(part, letter.text.data(), letter.text.size());
  curl_mime_type(part, "text/plain; charset=utf-8");
  curl_mime_encoder(part, "base64");
  const std::string host = settings_.from.substr(settings_.from.find('@'));
  List headers;
  Append(headers, "Date: " + DateText(letter.date));
  Append(headers, "From: <" + settings_.from + ">");
  Append(headers, "To: " + NameText(letter.to_name) + " <" + letter.to + ">");
  Append(headers, "Subject: " + HeaderText(letter.subject));
  Append(headers, "Message-ID: <" + letter.id + host + ">");
  Append(headers, "Auto-Submitted: auto-generated");
  List receivers;
  Append(receivers, letter.to);
  const bool near = settings_.insecure_loopback && IsLoopback(settings_.smtp);
  std::string words(CURL_ERROR_SIZE, '\0');
  std::string said;
  curl_easy_setopt(to, CURLOPT_URL, settings_.smtp.c_str());
  curl_easy_setopt(to, CURLOPT_PROTOCOLS_STR, "smtp,smtps");
  curl_easy_setopt(to, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(to, CURLOPT_USE_SSL, static_cast<long>(near ? CURLUSESSL_NONE : CURLUSESSL_ALL));
  curl_easy_setopt(to, CURLOPT_SSLVERSION, static_cast<long>(CURL_SSLVERSION_TLSv1_2));
  curl_easy_setopt(to, CURLOPT_CONNECTTIMEOUT_MS, kConnectMs);
  curl_easy_setopt(to, CURLOPT_TIMEOUT_MS, kDeadlineMs);
  if (!settings_.ca_file.empty()) curl_easy_setopt(to, CURLOPT_CAINFO, settings_.ca_file.c_str());
  if (!settings_.user.empty()) {
    curl_easy_setopt(to, CURLOPT_USERNAME, settings_.user.c_str());
    curl_easy_setopt(to, CURLOPT_PASSWORD, settings_.password.c_str());
  }
  curl_easy_setopt(to, CURLOPT_MAIL_FROM, ("<" + settings_.from + ">").c_str());
  curl_easy_setopt(to, CURLOPT_MAIL_RCPT, receivers.get());
  curl_easy_setopt(to, CURLOPT_HTTPHEADER, headers.get());
  curl_easy_setopt(to, CURLOPT_MIMEPOST, mime.get());
  curl_easy_setopt(to, CURLOPT_HEADERFUNCTION, Hear);
  curl_easy_setopt(to, CURLOPT_HEADERDATA, &said);
  curl_easy_setopt(to, CURLOPT_WRITEFUNCTION, Hear);
  curl_easy_setopt(to, CURLOPT_WRITEDATA, &said);
  curl_easy_setopt(to, CURLOPT_ERRORBUFFER, words.data());
  const CURLcode done = curl_easy_perform(to);
  if (done == CURLE_OK) return {};
  std::string why = words.substr(0, words.find('\0'));
  if (why.empty()) why = curl_easy_strerror(done);
  long code = 0;
  curl_easy_getinfo(to, CURLINFO_RESPONSE_CODE, &code);
  return Refused(done, code, why, said);
}

}  // namespace faultlab::server::mail
