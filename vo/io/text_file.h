#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gluevo::vo {

/// A text's lines with their numbers, without line ends (LF, CR LF or CR), a byte order mark at the
/// start of the text and blanks around each line.
struct TextLine {
  int number = 0;  ///< From 1.
  std::string text;
};

/// A file's contents. Throws Error naming the file where it cannot be read.
std::string ReadText(const std::filesystem::path& path);

/// Whether a line is a comment: it starts with '#', '%' or "//".
bool IsComment(std::string_view line);

/// All lines up to the last that is not blank; with `skip_comments` without blank ones and
/// comments. Throws Error naming `path` (which is not opened) where the text is UTF-16 or holds a
/// zero byte, which no text does.
std::vector<TextLine> SplitLines(std::string_view text, const std::filesystem::path& path,
                                 bool skip_comments);

/// The same of a file. Throws Error where it cannot be read, too.
std::vector<TextLine> ReadLines(const std::filesystem::path& path, bool skip_comments);

/// Whether no field of a line is a number: words, as in the first line of a table.
bool IsHeader(std::string_view line);

/// The rows of a table: lines without comments and without what precedes the first line that has a
/// number in it. Throws Error as ReadLines.
std::vector<TextLine> ReadTable(const std::filesystem::path& path);

/// ASCII letters in lower case, all else as it is.
std::string Lowercase(std::string_view text);

/// "FILE:LINE", for messages.
std::string At(const std::filesystem::path& path, const TextLine& line);

/// What separates the fields of a line of numbers: ';' or ',' where there is one, else ' '. Throws
/// Error naming file and line where the commas are those of decimal numbers.
char SeparatorOf(const std::filesystem::path& path, const TextLine& line);

/// Fields between separators; a blank as separator stands for any run of blanks and tabs. Blanks
/// around fields are dropped.
std::vector<std::string_view> SplitFields(std::string_view text, char separator);

/// A whole finite decimal number; nothing for anything else.
std::optional<double> ParseNumber(std::string_view text);

/// A whole decimal integer.
std::optional<int64_t> ParseInteger(std::string_view text);

/// A decimal number times ten to the power of `shift` as an integer: exact (rounded to the nearest)
/// for as many digits as the text has. Nothing for other text and where an int64_t cannot hold it.
std::optional<int64_t> ParseShifted(std::string_view text, int shift);

/// Decimal seconds, also as 1.5e+09, in nanoseconds: ParseShifted by 9. Nothing for other text
/// and for times beyond 292 years.
std::optional<int64_t> ParseSeconds(std::string_view text);

}  // namespace gluevo::vo
