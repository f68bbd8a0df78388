#pragma once

#include <optional>

#include "name_parts.h"

// Names of images that hold seconds and, apart from them, parts of seconds.
namespace gluevo::vo {

/// SECONDS_NANOSECONDS, the second padded with zeros or not; microseconds and milliseconds where it
/// never has more digits. Nothing for columns that are no such times.
std::optional<NameNumbers> SecondsAndParts(const NameColumn& seconds, const NameColumn& parts);

/// The same with a point between them. Written without padding "5.7000001" is 7000001 ns behind
/// the fifth second, not seven tenths: where the number of digits behind the point differs, none
/// begins with a zero, and the steps are then more even than those of decimal numbers. Else
/// nothing.
std::optional<NameNumbers> UnpaddedParts(const NameColumn& column);

}  // namespace gluevo::vo
