#include <cstddef>
#include <cstdint>
#include <string_view>

#include "gluevo/nn/error.h"
#include "text_file.h"
#include "trajectory_columns.h"

// Lines, fields and numbers of any text, as the readers of tables and lists of times take them.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size) {
  using namespace gluevo;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    for (const vo::TextLine& line : vo::SplitLines(text, "file", /*skip_comments=*/false)) {
      vo::ColumnsOfHeader(line.text);
      vo::IsHeader(line.text);
      for (const std::string_view field :
           vo::SplitFields(line.text, vo::SeparatorOf("file", line))) {
        const auto seconds = vo::ParseSeconds(field);
        // A time that is one is a number, too.
        if (seconds && !vo::ParseNumber(field)) {
          __builtin_trap();
        }
        vo::ParseInteger(field);
      }
    }
  } catch (const Error&) {  // The one answer that a broken file may get.
  }
  return 0;
}
