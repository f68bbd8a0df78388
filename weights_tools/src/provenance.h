#pragma once

#include <map>
#include <string>

namespace gluevo::weights_tools {

/// What a dialect tells of weights whose file says nothing: "licence" and "descriptors", notes for
/// people on the terms under which weights of this kind are published, and on which detectors and
/// matchers belong together. `network` is one of kNetworkNames.
std::map<std::string, std::string> UsualProvenance(const std::string& dialect,
                                                   const std::string& network);

}  // namespace gluevo::weights_tools
