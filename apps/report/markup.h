#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace gluevo::apps {

/// Text as HTML shows it, in elements and in quoted attributes: & < > " and ' are escaped, and what
/// is no UTF-8 or a control character becomes U+FFFD.
std::string Escape(std::string_view text);

/// A number with so many decimals; an en dash for one that is not finite. Negative numbers have a
/// real minus sign, and what rounds to 0 has none.
std::string Fixed(double value, int decimals);

/// The same for a place in a drawing: plain ASCII, at most one decimal, none where it would be 0.
std::string Coordinate(double value);

/// RFC 4648.
std::string Base64(const std::vector<uint8_t>& bytes);

}  // namespace gluevo::apps
