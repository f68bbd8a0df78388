#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

// In which unit whole numbers count time: clocks that people's cameras use count nanoseconds,
// microseconds, milliseconds or seconds, since 1970 or since they were switched on.
namespace gluevo::vo {

/// A unit by the power of ten of its parts in a second: 9 (nanoseconds), 6, 3 or 0 (seconds).
using StampUnit = int;

/// "nanoseconds", "microseconds", "milliseconds" or "seconds".
std::string UnitName(StampUnit unit);

/// "1.5 ms" or the like, for messages.
std::string TimeText(int64_t duration_ns);

/// The unit in which all stamps lie between 1998 and 2103 and follow each other within 0.1 ms to
/// 20 s; the four ranges of numbers have nothing in common.
std::optional<StampUnit> UnitSince1970(const std::vector<int64_t>& stamps);

/// The unit in which the step lies between 5 ms and 5 s; nanoseconds for all longer ones and
/// seconds for all shorter ones.
StampUnit UnitOfStep(int64_t step);

/// The unit of numbers in the names of images: that since 1970; that of the step where it is so
/// long (5000) that they don't count images; milliseconds where steps of 10 or more are nearly the
/// same, but not quite, as no numbering of images would have it. Nothing for other numbers.
std::optional<StampUnit> UnitOfNames(const std::vector<int64_t>& numbers);

/// A stamp in nanoseconds; nothing beyond 292 years.
std::optional<int64_t> InNanoseconds(int64_t stamp, StampUnit unit);

/// The same of a decimal number in a unit: "1403715273262.5" milliseconds.
std::optional<int64_t> DecimalInNanoseconds(std::string_view text, StampUnit unit);

/// The unit of decimal numbers: seconds, or what follows from their size where they count from
/// 1970.
StampUnit UnitOfDecimals(double largest);

/// "2011-09-26 13:02:25.964389445" (also with a T between, and with "Z" or "+02:00" behind), in
/// nanoseconds since 1970.
std::optional<int64_t> ParseDateTime(std::string_view text);

}  // namespace gluevo::vo
