#include "command_line/message.h"

#include <iostream>

namespace gluevo::apps {

std::string OneLine(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string line;
  line.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    // U+0080 to U+009F in UTF-8: terminals heed them, too.
    const bool is_second_set = byte == 0xc2 && i + 1 < text.size() &&
                               (static_cast<unsigned char>(text[i + 1]) & 0xe0U) == 0x80U;
    if (byte >= 0x20 && byte != 0x7f && !is_second_set) {
      line += text[i];
      continue;
    }
    for (std::size_t last = i + (is_second_set ? 1 : 0); i <= last; ++i) {
      const auto control = static_cast<unsigned char>(text[i]);
      line += "\\x";
      line += kDigits[control >> 4];
      line += kDigits[control & 15];
    }
    --i;
  }
  return line;
}

void PrintMessage(std::string_view head, std::string_view text) {
  std::cerr << head << ": " << OneLine(text) << '\n';
}

}  // namespace gluevo::apps
