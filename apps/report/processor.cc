#include "processor.h"

#include <sys/utsname.h>

#include <fstream>

namespace gluevo::apps {

std::string ProcessorName() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    const std::size_t colon = line.find(": ");
    if (line.rfind("model name", 0) == 0 && colon != std::string::npos) {
      return line.substr(colon + 2);
    }
  }
  utsname machine = {};
  return uname(&machine) == 0 ? machine.machine : "unknown";
}

}  // namespace gluevo::apps
