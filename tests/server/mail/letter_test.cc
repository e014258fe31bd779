#include "server/mail/letter.h"

#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "server/mail/smtp_client.h"

namespace faultlab::server::mail {
namespace {

TEST(Letter, AnAddressIsOneWordWithOneAt) {
  for (const char* good : {"ann@example.org", "RA-301.2026+x@ftn.example", "a@b"}) {
    EXPECT_TRUE(IsAddress(good)) << good;
  }
  for (const std::string bad : {"",
                                "ann",
                                "@example.org",
                                "ann@",
                                "a@b@c",
                                "a b@c",
                                "a@c\r\nBcc: x@y",
                                "a@c>",
                                "<a@c",
                                "\"a\"@c",
                                "a,b@c",
                                "-oX@c",
                                "žarko@c"}) {
    EXPECT_FALSE(IsAddress(bad)) << bad;
  }
  EXPECT_FALSE(IsAddress(std::string(250, 'a') + "@b.cd"));
}

TEST(Letter, HeadersAreAsciiAndCutBetweenLetters) {
  EXPECT_EQ(HeaderText("Drives 1"), "Drives 1");
  EXPECT_EQ(HeaderText("Žarko"), "=?UTF-8?B?xb1hcmtv?=");
  EXPECT_EQ(HeaderText("=?x"), "=?UTF-8?B?PT94?=") << "nobody takes it for an encoded word";
  EXPECT_EQ(HeaderText("a\r\nBcc: x@y"), "=?UTF-8?B?YQ0KQmNjOiB4QHk=?=") << "no header of its own";
  std::string text;
  for (int i = 0; i < 50; ++i) text += "ж";
  const std::string header = HeaderText(text);
  EXPECT_EQ(header.find("=?UTF-8?B?"), 0U);
  for (std::size_t from = 0; from < header.size();) {
    const std::size_t end = std::min(header.find(' ', from), header.size());
    EXPECT_LE(end - from, 75U);
    EXPECT_EQ((end - from - 12) % 4, 0U);
    from = end + 1;
  }
  EXPECT_NE(header.find(" =?UTF-8?B?0LbQ"), std::string::npos) << "each begins with a whole letter";
}

TEST(Letter, ANameIsOneWordOfItsHeader) {
  EXPECT_EQ(NameText("Anna Kiss 2"), "Anna Kiss 2");
  EXPECT_EQ(NameText("Kiss, Anna"), "=?UTF-8?B?S2lzcywgQW5uYQ==?=") << "no second address";
}

TEST(Letter, ADateIsThatOfRfc5322) {
  EXPECT_EQ(DateText(WallTime(std::chrono::milliseconds(1'700'000'000'999))),
            "Tue, 14 Nov 2023 22:13:20 +0000");
}

TEST(SmtpClient, AServerHasASchemeAndNoUser) {
  EXPECT_TRUE(SmtpClient::IsServer("smtp://mail.example.org:587"));
  EXPECT_TRUE(SmtpClient::IsServer("smtps://mail.example.org"));
  for (const char* bad :
       {"", "mail.example.org", "http://mail.example.org", "smtp://u@h", "smtp://a b"}) {
    EXPECT_FALSE(SmtpClient::IsServer(bad)) << bad;
  }
}

TEST(SmtpClient, AServerThatIsAwayMayComeBack) {
  MailSettings settings;
  settings.smtp = "smtp://127.0.0.1:1";
  settings.from = "lab@example.org";
  Letter letter;
  letter.to = "ann@example.org";
  const notify::Attempt attempt = SmtpClient(settings).Send(letter);
  EXPECT_EQ(attempt.outcome, notify::Attempt::Outcome::kNotNow);
  EXPECT_NE(attempt.error, "");
}

}  // namespace
}  // namespace faultlab::server::mail
