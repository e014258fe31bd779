#include "server/plots/figure.h"

namespace faultlab::server {

std::string PlainText(const std::string& text) {
  std::string plain;
  bool inside = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool opens = (text[i] == '_' || text[i] == '^') && i + 1 < text.size() &&
                       text[i + 1] == '{' && text.find('}', i) != std::string::npos;
    if (opens && !inside) {
      inside = true;
      ++i;
    } else if (inside && text[i] == '}') {
      inside = false;
    } else {
      plain += text[i];
    }
  }
  return plain;
}

}  // namespace faultlab::server
