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

TEST(Utf8, IsMadeOfWindows1252) {
  std::string all;
  for (int byte = 1; byte < 256; ++byte) all += static_cast<char>(byte);
  const std::string text = FromWindows1252(all);
  EXPECT_TRUE(IsUtf8(text));
  EXPECT_EQ(FromWindows1252("5 \x80, W\xE4rme \xB5s \x96 \x9C"), "5 €, Wärme µs – œ");
  std::string back;
  for (std::string_view rest = text; !rest.empty();) {
    const Utf8Character first = FirstCharacter(rest);
    AppendUtf8(back, first.code);
    rest.remove_prefix(first.bytes);
  }
  EXPECT_EQ(back, text);
  std::string none;
  AppendUtf8(none, 0xD800);
  AppendUtf8(none, 0x110000);
  EXPECT_EQ(none, "\uFFFD\uFFFD");
}

TEST(Utf8, WordsAreComparedInPlainLetters) {
  const std::pair<const char*, const char*> words[] = {{"Tensão", "tensao"},
                                                       {"NAPIĘCIE", "napiecie"},
                                                       {"hız", "hiz"},
                                                       {"Größe", "grose"},
                                                       {"velocità", "velocita"},
                                                       {"Číslo", "cislo"},
                                                       {"őÜ", "ou"},
                                                       {"turație", "turatie"},
                                                       {"брзина", "brzina"},
                                                       {"Његош", "negos"},
                                                       {"µs", "us"},
                                                       {"μs", "us"},
                                                       {"°/s", "deg/s"},
                                                       {"ω [rad·s⁻¹]", "omega [rad*s-1]"},
                                                       {"温度", "??"},
                                                       {"e\u0301te\u0301", "ete"},
                                                       {"\xff!", "?!"}};
  for (const auto& [written, plain] : words) EXPECT_EQ(PlainLetters(written), plain) << written;
}

}  // namespace
}  // namespace faultlab::core
