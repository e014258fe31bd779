#include "server/auth/person_name.h"

#include <gtest/gtest.h>

namespace faultlab::server {
namespace {

TEST(PersonName, KeepsEveryLetter) {
  EXPECT_EQ(CleanName("Đorđe Petrović-Njegoš"), "Đorđe Petrović-Njegoš");
  EXPECT_EQ(CleanName("Мила О'Брајан"), "Мила О'Брајан");
  EXPECT_EQ(CleanName("陳 大文 🙂"), "陳 大文 🙂");
}

TEST(PersonName, DropsWhatNobodySees) {
  EXPECT_EQ(CleanName(std::string_view("A\0nn\x7F\r\n", 7)), "Ann");
  EXPECT_EQ(CleanName("\u202EnnA\u2066 \u200BLee\uFEFF\u0085"), "nnA Lee");
  EXPECT_EQ(CleanName("Ann\tLee"), "Ann Lee");
  EXPECT_EQ(CleanName("\u200B \u202E"), "");
}

TEST(PersonName, IsNoFormula) {
  EXPECT_EQ(CleanName("=HYPERLINK(\"http://x\")"), "HYPERLINK(\"http://x\")");
  EXPECT_EQ(CleanName("\u200B=+@-1+1"), "1+1");
  EXPECT_EQ(CleanName("  Ann  "), "Ann");
}

}  // namespace
}  // namespace faultlab::server
