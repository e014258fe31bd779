#include "core/types/utf8.h"

#include <gtest/gtest.h>

#include <string>

namespace faultlab::core {
namespace {

TEST(Utf8, IsWhatRfc3629Allows) {
  for (const char* good :
       {"", "a", "\u00e9", "\u20ac", "\U0001F600", "R1 = 100 Ω, школа 🙂", "\U0010FFFF"}) {
    EXPECT_TRUE(IsUtf8(good)) << good;
  }
  for (const char* bad : {"\x80",  // no beginning
                          "\xc3",  // cut
                          "a\xe2\x82",
                          "\xc3(",     // bad continuation
                          "\xc0\xaf",  // overlong
                          "\xe0\x80\xaf",
                          "\xf0\x80\x80\x80",
                          "\xed\xa0\x80",      // surrogate
                          "\xf4\x90\x80\x80",  // beyond U+10FFFF
                          "\xf5\x80\x80\x80",
                          "\xf8\x88\x80\x80\x80",
                          "\xff"}) {
    EXPECT_FALSE(IsUtf8(bad)) << bad;
  }
}

TEST(Utf8, IsReadCharacterByCharacter) {
  std::u32string codes;
  std::string_view text = "aé\xff€\xe2\x82\U0001F600\xc3";
  while (!text.empty()) {
    const Utf8Character first = FirstCharacter(text);
    EXPECT_EQ(first.valid, first.code != 0xFFFD);
    codes += first.code;
    text.remove_prefix(first.bytes);
  }
  EXPECT_EQ(codes, U"aé\uFFFD€\uFFFD\uFFFD\U0001F600\uFFFD");
  EXPECT_TRUE(FirstCharacter("\uFFFD").valid) << "it may be meant";
}

TEST(Utf8, IsCutBetweenCharacters) {
  EXPECT_EQ(CutUtf8("amé", 4), "amé");
  EXPECT_EQ(CutUtf8("amé", 3), "am");
  EXPECT_EQ(CutUtf8("\U0001F600", 3), "");
  EXPECT_EQ(CutUtf8("", 0), "");
}

}  // namespace
}  // namespace faultlab::core
