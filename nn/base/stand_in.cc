#include "gluevo/nn/stand_in.h"

#include <algorithm>
#include <cctype>
#include <string>

namespace gluevo::nn {
namespace {

/// The first characters in lower case, without blanks and a byte order mark before them.
std::string LowerBeginning(std::string_view text) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  constexpr std::size_t kLength = 64;
  if (text.starts_with(kByteOrderMark)) {
    text.remove_prefix(kByteOrderMark.size());
  }
  text = text.substr(std::min(text.find_first_not_of(" \t\r\n"), text.size()), kLength);
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

}  // namespace

std::optional<StandIn> FindStandIn(std::string_view beginning) {
  if (beginning.starts_with("version https://git-lfs")) {
    return StandIn{"a pointer of Git LFS", "fetch the file itself with git lfs pull"};
  }
  if (beginning.starts_with("/annex/objects/")) {
    return StandIn{"a pointer of git-annex", "fetch the file itself with git annex get"};
  }
  const std::string lower = LowerBeginning(beginning);
  for (const std::string_view tag : {"<!doctype html", "<html", "<head", "<!--"}) {
    if (lower.starts_with(tag)) {
      return StandIn{"a web page", "was it not downloaded as it should be?", true};
    }
  }
  return std::nullopt;
}

}  // namespace gluevo::nn
