#include "server/auth/class_list_text.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <utility>

#include "core/types/utf8.h"
#include "server/auth/accounts.h"
#include "server/auth/person_name.h"

namespace faultlab::server {
namespace {

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

/// What a column says of a student, by its title.
enum class Column { kNothing, kLogin, kNumber, kMail, kName, kFirst, kLast };

/// Titles as programs and people write them: small letters without accents, and nothing else.
struct ColumnWords {
  Column column;
  std::string_view words;
};
constexpr std::array<ColumnWords, 6> kTitles = {{
    {Column::kLogin,
     "login username user loginid sisloginid benutzername benutzer anmeldename kennung korisnik "
     "korisnickoime usuario nombredeusuario identifiant nomeutente nomedeusuario kullaniciadi "
     "uzytkownik gebruikersnaam brukernavn anvandarnamn kayttajatunnus netid account"},
    {Column::kNumber,
     "id idnumber studentid studentnumber sisuserid matrikelnummer matrikelnr matrikel indeks "
     "index brojindeksa matricula nrindeksu numerindeksu numeroalbumu ogrencino numero matricola "
     "numeromatricola numeroetudiant studentnummer opiskelijanumero broj sifra"},
    {Column::kMail,
     "email mail emailaddress emailadresse correo correoelectronico direcciondecorreo eposta imejl "
     "adresemail adresseemail posta mejl ename epostasi"},
    {Column::kName,
     "name fullname student studentname imeiprezime prezimeiime nombrecompleto nombreyapellidos "
     "vorundnachname nomcomplet nomecompleto nomecognome cognomenome imienazwisko nazwiskoiimie "
     "adsoyad volledigenaam"},
    {Column::kFirst,
     "firstname givenname vorname ime nombre prenom nome imie ad voornaam fornavn fornamn etunimi "
     "keresztnev prenume jmeno"},
    {Column::kLast,
     "lastname surname familyname nachname familienname prezime apellido apellidos nom cognome "
     "sobrenome nazwisko soyad achternaam etternavn efternamn sukunimi vezeteknev nume prijmeni"},
}};

Column ColumnOf(std::string_view title) {
  std::string plain = core::PlainLetters(title);
  std::erase_if(plain, [](char c) { return c < 'a' || c > 'z'; });
  if (plain.empty()) return Column::kNothing;
  for (const ColumnWords& each : kTitles) {
    std::string_view rest = each.words;
    while (!rest.empty()) {
      const std::size_t end = std::min(rest.find(' '), rest.size());
      if (rest.substr(0, end) == plain) return each.column;
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
  }
  return Column::kNothing;
}

/// "RA 301/2026" is ra-301-2026. What has no digit is no index number and stays as it is.
std::string LoginText(std::string_view field) {
  std::string login;
  const bool number = field.find_first_of("0123456789") != std::string_view::npos;
  for (const char c : Trimmed(field)) {
    const bool parts = number && (c == ' ' || c == '/' || c == '\\');
    if (!parts) login.push_back(c);
    if (parts && !login.ends_with('-')) login.push_back('-');
  }
  return Lower(std::move(login));
}
bool HasDigitOrAt(std::string_view text) {
  return text.find_first_of("0123456789@") != std::string_view::npos;
}

class ClassList {
 public:
  core::Result<ClassListText> Read(std::string_view text) {
    Split(text);
    if (rows_.size() > kLinesMax + 1) return core::Refuse("list_too_long");
    std::size_t first = 0;
    if (FindTitles()) first = 1;
    if (!titled_ && HasColumns()) {
      const Row& row = rows_.front();
      return core::Refuse("list_columns_unclear", "", {{"columns", std::string(row.line)}});
    }
    for (std::size_t i = first; i < rows_.size(); ++i) {
      if (titled_ && IsTotal(rows_[i])) continue;
      TRY_DONE(Take(rows_[i]));
    }
    if (out_.lines.empty()) return core::Refuse("list_empty");
    return std::move(out_);
  }

 private:
  struct Row {
    std::size_t number = 0;  ///< of its line
    std::vector<std::string> fields;
    std::string_view line;
  };

  void Split(std::string_view text) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    constexpr std::string_view kSays = "sep=";
    if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
    for (std::size_t number = 1; !text.empty(); ++number) {
      const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
      const std::string_view line = text.substr(0, end);
      const std::size_t mark = text.substr(end).starts_with("\r\n") ? 2 : 1;
      text.remove_prefix(std::min(end + mark, text.size()));
      if (Trimmed(line).empty()) continue;
      if (separator_ == '\0' && Trimmed(line).starts_with(kSays) && line.size() > kSays.size()) {
        separator_ = line[kSays.size()];
        continue;
      }
      if (separator_ == '\0') separator_ = SeparatorOf(line);
      Row row{number, FieldsOf(line, separator_), line};
      if (line.find_first_not_of(" \t\",;") == std::string_view::npos) continue;
      rows_.push_back(std::move(row));
      if (rows_.size() > kLinesMax + 1) return;  // of titles, and one too many
    }
  }

  /// Whether the first row is of titles: it has no digit and no @, and names a login or a name.
  bool FindTitles() {
    if (rows_.empty()) return false;
    const std::vector<std::string>& titles = rows_.front().fields;
    if (std::ranges::any_of(titles, HasDigitOrAt)) return false;
    const auto at = [&](Column wanted) {
      for (std::size_t i = 0; i < titles.size(); ++i) {
        if (ColumnOf(titles[i]) == wanted) return std::optional(i);
      }
      return std::optional<std::size_t>();
    };
    std::optional<std::size_t> login;
    for (const Column each : {Column::kLogin, Column::kNumber, Column::kMail}) {
      if (!login && at(each) && IsFull(*at(each))) login = at(each);
    }
    const auto name = at(Column::kName), first = at(Column::kFirst), last = at(Column::kLast);
    for (const auto& each : {first, last ? last : name}) {
      if (each) names_at_.push_back(*each);
    }
    if (!login && (!names_at_.empty() || StandsOut())) login = Like(HasDigitOrAt);
    if (login && names_at_.empty()) {
      const auto is_word = [](std::string_view text) { return !HasDigitOrAt(text); };
      if (const auto like = Like(is_word, login)) names_at_ = {*like};
    }
    if (!login || names_at_.empty()) return false;
    titled_ = true;
    login_at_ = *login;
    mail_at_ = at(Column::kMail);
    if (mail_at_ == login) mail_at_ = std::nullopt;
    if (mail_at_) out_.mail_from = titles[*mail_at_];
    out_.login_from = titles[login_at_];
    for (const std::size_t each : names_at_) {
      out_.name_from += (out_.name_from.empty() ? "" : " + ") + titles[each];
    }
    return true;
  }

  /// Without titles what follows the login is the name. Where it is an address or a number, and the
  /// login is a word, the first column may as well be a name.
  bool HasColumns() const {
    const auto is_number = [](std::string_view text) {
      constexpr std::ptrdiff_t kDigits = 4;
      const auto digits = std::ranges::count_if(text, [](char c) { return c >= '0' && c <= '9'; });
      return text.find('@') != std::string_view::npos || digits >= kDigits;
    };
    for (std::size_t i = 1; rows_.size() > 1 && i < rows_.front().fields.size(); ++i) {
      const auto row_has = [&](const Row& row) {
        return row.fields.size() > i && is_number(row.fields[i]) && !HasDigitOrAt(row.fields[0]);
      };
      if (std::all_of(rows_.begin() + 1, rows_.end(), row_has)) return true;
    }
    return false;
  }

  bool IsFull(std::size_t column) const {
    return std::all_of(rows_.begin() + 1, rows_.end(), [&](const Row& row) {
      return IsTotal(row) || (row.fields.size() > column && !row.fields[column].empty());
    });
  }

  /// The first column that is full of what `is` says; not `but`.
  template <typename Is>
  std::optional<std::size_t> Like(const Is& is, std::optional<std::size_t> but = {}) const {
    for (std::size_t i = 0; rows_.size() > 1 && i < rows_.front().fields.size(); ++i) {
      const bool all =
          IsFull(i) && std::all_of(rows_.begin() + 1, rows_.end(), [&](const Row& row) {
            return IsTotal(row) || is(row.fields[i]);
          });
      if (all && i != but) return i;
    }
    return std::nullopt;
  }

  /// The second row of Canvas is of no student.
  static bool IsTotal(const Row& row) { return Trimmed(row.fields.front()) == "Points Possible"; }

  /// Titles of which nobody here has heard: capitals, above logins that all have a digit or an @.
  bool StandsOut() const {
    const auto has = [](const Row& row) { return HasDigitOrAt(row.fields.front()); };
    const auto capital = [](const std::string& title) {
      return !title.empty() && !(title.front() >= 'a' && title.front() <= 'z');
    };
    return rows_.size() > 2 && std::ranges::all_of(rows_.front().fields, capital) &&
           std::all_of(rows_.begin() + 1, rows_.end(), has);
  }

  static core::Error Refusal(std::string_view reason, const Row& row) {
    return core::Refuse(reason, "", {{"line", row.number}});
  }

  core::Status Take(const Row& row) {
    std::string name;
    if (titled_) {
      const std::size_t last = std::max(login_at_, std::ranges::max(names_at_));
      if (row.fields.size() <= last) return Refusal("line_without_name", row);
      for (const std::size_t each : names_at_) {
        name += (name.empty() || row.fields[each].empty() ? "" : " ") + row.fields[each];
      }
    } else {
      // What follows the login, whatever stands in it.
      std::string_view line = row.line;
      (void)TakeField(line, separator_);
      if (line.empty()) return Refusal("line_without_name", row);
      line = Trimmed(line.substr(1));
      name = line.starts_with('"') ? TakeField(line, separator_) : std::string(line);
    }
    const bool has_mail = mail_at_ && *mail_at_ < row.fields.size();
    return Add(row,
               LoginText(row.fields[login_at_]),
               CleanName(name),
               has_mail ? row.fields[*mail_at_] : std::string());
  }

  core::Status Add(const Row& row, const std::string& login, std::string name, std::string mail) {
    const auto normal = NormalLogin(login);
    if (!normal.ok()) return Refusal("line_login_wrong", row);
    if (name.empty() || name.size() > kListedNameBytesMax) {
      return Refusal("line_name_length", row);
    }
    const auto [before, is_new] = names_.emplace(normal.value(), name);
    if (!is_new && before->second != name) {
      return core::Refuse(
          "line_login_twice", "", {{"line", row.number}, {"login", normal.value()}});
    }
    if (!is_new) return core::Done{};
    if (out_.lines.size() == kLinesMax) {
      return core::Refuse("list_too_long");
    }
    out_.lines.push_back({normal.value(), std::move(name), std::move(mail)});
    return core::Done{};
  }

  std::vector<Row> rows_;
  ClassListText out_;
  std::map<std::string, std::string> names_;  ///< by login
  char separator_ = '\0';
  bool titled_ = false;
  std::size_t login_at_ = 0;
  std::optional<std::size_t> mail_at_;
  std::vector<std::size_t> names_at_;
};

}  // namespace

core::Result<ClassListText> ParseClassList(std::string_view utf8) {
  return ClassList().Read(utf8);
}

}  // namespace faultlab::server
