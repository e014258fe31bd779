#include "server/auth/class_list_text.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <utility>

#include "server/auth/accounts.h"
#include "server/auth/person_name.h"

namespace faultlab::server {
namespace {

using core::Error;

constexpr std::size_t kLinesMax = 5000;
constexpr std::size_t kListedNameBytesMax = 200;
constexpr std::string_view kSeparators = ",;\t";

std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t from = std::min(text.find_first_not_of(kBlank), text.size());
  text.remove_prefix(from);
  return text.substr(0, text.find_last_not_of(kBlank) + 1);
}

/// Takes the first field off a line, and its separator if there is one. In quotes, two quotes are
/// one.
std::string TakeField(std::string_view& line, char separator) {
  line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
  std::string field;
  if (line.starts_with('"')) {
    std::size_t at = 1;
    for (; at < line.size(); ++at) {
      const bool quote = line[at] == '"';
      if (quote && line.substr(at + 1, 1) != "\"") break;
      field.push_back(line[at]);
      if (quote) ++at;
    }
    line.remove_prefix(std::min(at + 1, line.size()));
  } else {
    field = Trimmed(line.substr(0, line.find(separator)));
  }
  line.remove_prefix(std::min(line.find(separator), line.size()));
  return field;
}

std::vector<std::string> FieldsOf(std::string_view line, char separator) {
  std::vector<std::string> fields{TakeField(line, separator)};
  while (!line.empty()) {
    line.remove_prefix(1);
    fields.push_back(TakeField(line, separator));
  }
  return fields;
}

std::string Lower(std::string text) {
  std::ranges::transform(
      text, text.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c; });
  return text;
}

/// The first one that is not in quotes.
char SeparatorOf(std::string_view line) {
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    if (!quoted && kSeparators.find(c) != std::string_view::npos) return c;
  }
  return kSeparators.front();
}

class ClassList {
 public:
  core::Result<std::vector<ClassListLine>> Read(std::string_view text) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      std::string_view line = text.substr(0, end);
      if (line.ends_with('\r')) line.remove_suffix(1);
      text.remove_prefix(std::min(end + 1, text.size()));
      ++number_;
      if (Trimmed(line).empty()) continue;
      if (const core::Status taken = Take(line); !taken.ok()) return taken.error();
    }
    if (lines_.empty()) {
      return core::Refuse("list_empty");
    }
    return std::move(lines_);
  }

 private:
  Error Refusal(std::string_view reason) const {
    return core::Refuse(reason, "", {{"line", number_}});
  }

  /// Whether the first line says how to read the others.
  bool IsHead(std::string_view line) {
    constexpr std::string_view kSays = "sep=";
    const std::string_view plain = Trimmed(line);
    if (plain.starts_with(kSays) && line.size() > kSays.size()) {
      separator_ = line[kSays.size()];
      return true;
    }
    if (separator_ == '\0') separator_ = SeparatorOf(line);
    if (head_is_past_) return false;
    head_is_past_ = true;
    std::vector<std::string> names = FieldsOf(line, separator_);
    std::ranges::transform(names, names.begin(), Lower);
    const auto login = std::ranges::find(names, "login");
    const auto name = std::ranges::find(names, "name");
    if (login == names.end() || name == names.end()) return false;
    login_at_ = static_cast<std::size_t>(login - names.begin());
    name_at_ = static_cast<std::size_t>(name - names.begin());
    named_ = true;
    return true;
  }

  core::Status Take(std::string_view line) {
    if (!head_is_past_ && IsHead(line)) return core::Done{};
    std::string login;
    std::string name;
    if (named_) {
      const std::vector<std::string> fields = FieldsOf(line, separator_);
      if (fields.size() <= std::max(login_at_, name_at_)) {
        return Refusal("line_without_name");
      }
      login = fields[login_at_];
      name = fields[name_at_];
    } else {
      login = TakeField(line, separator_);
      if (line.empty()) return Refusal("line_without_name");
      line = Trimmed(line.substr(1));
      name = line.starts_with('"') ? TakeField(line, separator_) : std::string(line);
    }
    return Add(login, CleanName(name));
  }

  core::Status Add(const std::string& login, std::string name) {
    const auto normal = NormalLogin(login);
    if (!normal.ok()) return Refusal("line_login_wrong");
    if (name.empty() || name.size() > kListedNameBytesMax) {
      return Refusal("line_name_length");
    }
    const auto [before, is_new] = names_.emplace(normal.value(), name);
    if (!is_new && before->second != name) {
      return core::Refuse("line_login_twice", "", {{"line", number_}, {"login", normal.value()}});
    }
    if (!is_new) return core::Done{};
    if (lines_.size() == kLinesMax) {
      return core::Refuse("list_too_long");
    }
    lines_.push_back({normal.value(), std::move(name)});
    return core::Done{};
  }

  std::vector<ClassListLine> lines_;
  std::map<std::string, std::string> names_;  ///< by login
  std::size_t number_ = 0;
  char separator_ = '\0';
  bool head_is_past_ = false;
  bool named_ = false;
  std::size_t login_at_ = 0;
  std::size_t name_at_ = 0;
};

}  // namespace

core::Result<std::vector<ClassListLine>> ParseClassList(std::string_view utf8) {
  return ClassList().Read(utf8);
}

}  // namespace faultlab::server
