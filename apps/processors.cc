#include "processors.h"

#include <sched.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <opencv2/core/utility.hpp>
#include <set>
#include <string_view>
#include <system_error>
#include <thread>

#include "gluevo/nn/error.h"
#include "gluevo/nn/option_error.h"

namespace gluevo::apps {
namespace {

cpu_set_t UsableProcessors() {
  cpu_set_t usable;
  CPU_ZERO(&usable);
  if (sched_getaffinity(0, sizeof(usable), &usable) != 0) {
    throw Error("the processors of this process are not known: " +
                std::generic_category().message(errno));
  }
  return usable;
}

// The number that the text is; -1 where it is none.
int Number(std::string_view text) {
  int number = -1;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
  return code == std::errc() && end == text.data() + text.size() ? number : -1;
}

}  // namespace

std::vector<int> ParseProcessors(const std::string& text) {
  const cpu_set_t usable = UsableProcessors();
  std::set<int> processors;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    const std::size_t dash = part.find('-');
    const int first = Number(std::string_view(part).substr(0, dash));
    const int last =
        dash == std::string::npos ? first : Number(std::string_view(part).substr(dash + 1));
    if (first < 0 || last < first || last >= CPU_SETSIZE) {
      throw OptionError("--cpus is " + Quoted(text) +
                        "; expected numbers of processors as in 0,2-3");
    }
    for (int processor = first; processor <= last; ++processor) {
      if (!CPU_ISSET(processor, &usable)) {
        throw OptionError("--cpus names processor " + std::to_string(processor) +
                          "; expected one that is there and that this process may use");
      }
      processors.insert(processor);
    }
    begin = end + 1;
  }
  return {processors.begin(), processors.end()};
}

void UseProcessors(const std::string& text) {
  if (text.empty()) {
    return;
  }
  cpu_set_t chosen;
  CPU_ZERO(&chosen);
  for (const int processor : ParseProcessors(text)) {
    CPU_SET(processor, &chosen);
  }
  if (sched_setaffinity(0, sizeof(chosen), &chosen) != 0) {
    throw Error("--cpus " + text + ": " + std::generic_category().message(errno));
  }
}

int ThreadsOf(int asked) {
  if (asked > 0) {
    return asked;
  }
  const cpu_set_t usable = UsableProcessors();
  return std::max(1, CPU_COUNT(&usable));
}

void UseKernelThreads(int threads) { cv::setNumThreads(std::min(threads, ThreadsOf(0))); }

}  // namespace gluevo::apps
