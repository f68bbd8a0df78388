#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gluevo::vo {

/// A text file's lines with their numbers, without line ends (LF, CR LF or CR), a byte order mark
/// at the start of the file and blanks around each line.
struct TextLine {
  int number = 0;  ///< From 1.
  std::string text;
};

/// A file's contents. Throws Error naming the file where it cannot be read.
std::string ReadText(const std::filesystem::path& path);

/// The lines of a text; those that ReadLines gives of a file.
std::vector<TextLine> SplitLines(std::string_view text, bool skip_comments);

/// All lines up to the last that is not blank; with `skip_comments` without blank ones and those
/// that start with '#'. Throws Error where the file cannot be read.
std::vector<TextLine> ReadLines(const std::filesystem::path& path, bool skip_comments);

/// "FILE:LINE", for messages.
std::string At(const std::filesystem::path& path, const TextLine& line);

/// Fields between separators; a blank as separator stands for any run of blanks and tabs. Blanks
/// around fields are dropped.
std::vector<std::string_view> SplitFields(std::string_view text, char separator);

/// A whole finite decimal number; nothing for anything else.
std::optional<double> ParseNumber(std::string_view text);

/// A whole decimal integer.
std::optional<int64_t> ParseInteger(std::string_view text);

/// Decimal seconds, also as 1.5e+09, in nanoseconds: exact (rounded to the nearest) for as many
/// digits as the text has. Nothing for other text and for times beyond 292 years.
std::optional<int64_t> ParseSeconds(std::string_view text);

}  // namespace gluevo::vo
