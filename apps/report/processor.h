#pragma once

#include <string>

namespace gluevo::apps {

/// The processor's name as Linux gives it in /proc/cpuinfo, else the machine's architecture.
std::string ProcessorName();

}  // namespace gluevo::apps
