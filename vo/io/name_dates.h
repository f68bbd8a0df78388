#pragma once

#include <optional>
#include <vector>

#include "name_parts.h"

namespace gluevo::vo {

/// Names that are dates with a time of day: 20230501120058[500], 20230501T120058.500,
/// 2023-05-01_12-00-58-500000 and their like, whatever stands between the numbers, taken as UTC.
/// Digits behind the seconds are decimals of them; a number of its own behind "_" or "-" is so only
/// where the seconds before it differ (else it may count images), or where it has three, six or
/// nine digits and steps on as parts of a second do. All parts have the same skeleton. Nothing
/// where not all names are such dates.
std::optional<NameNumbers> DatesOf(const std::vector<NameParts>& parts);

}  // namespace gluevo::vo
