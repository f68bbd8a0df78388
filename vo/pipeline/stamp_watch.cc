#include "stamp_watch.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "gluevo/vo/core/options_check.h"
#include "gluevo/vo/core/seconds.h"

namespace gluevo::vo::internal {
namespace {

// Farther back than stamps come out of order, farther ahead than arrival is uneven.
constexpr int64_t kStepBackNs = 500'000'000;
constexpr int64_t kStepAheadNs = 1'000'000'000;
// Arrival is uneven by less than this: two sensors that step by the same have one clock.
constexpr int64_t kSameStepNs = 200'000'000;

}  // namespace

StampWatch::Judged StampWatch::Judge(int64_t stamp_ns, int64_t now_ns, int64_t other_shift_ns) {
  const int64_t shifted = stamp_ns + shift_ns_;
  if (has_last_ &&
      (shifted <= last_ns_ - kStepBackNs || now_ns - shifted < least_age_ns_ - kStepAheadNs)) {
    return GoOn(stamp_ns, now_ns, other_shift_ns);
  }
  if (has_last_ && shifted <= last_ns_) {
    (shifted == last_ns_ ? still_ : back_) += 1;
    std::string warning;
    if (!std::exchange(is_leaving_out_, true)) {
      warning = shifted == last_ns_
                    ? "the " + sensor_ + "'s stamps stand still: left out"
                    : "the " + sensor_ + "'s stamps go back by " +
                          ShortText(SecondsBetween(shifted, last_ns_)) + " s: left out";
    }
    return {std::nullopt, std::move(warning)};
  }
  least_age_ns_ = has_last_ ? std::min(least_age_ns_, now_ns - shifted) : now_ns - shifted;
  has_last_ = true;
  is_leaving_out_ = false;
  last_ns_ = shifted;
  last_now_ns_ = now_ns;
  return {shifted, ""};
}

StampWatch::Judged StampWatch::GoOn(int64_t stamp_ns, int64_t now_ns, int64_t other_shift_ns) {
  const double step_s = SecondsBetween(last_ns_ + (now_ns - last_now_ns_), stamp_ns + shift_ns_);
  const int64_t next_ns = last_ns_ + std::max<int64_t>(1'000'000, now_ns - last_now_ns_);
  const int64_t by_other_ns = stamp_ns + other_shift_ns;
  const bool is_others = by_other_ns > last_ns_ && std::abs(by_other_ns - next_ns) < kSameStepNs;
  last_ns_ = is_others ? by_other_ns : next_ns;
  shift_ns_ = last_ns_ - stamp_ns;
  last_now_ns_ = now_ns;
  least_age_ns_ = now_ns - last_ns_;
  is_leaving_out_ = false;
  ++steps_;
  return {last_ns_, "the " + sensor_ + "'s clock stepped " + (step_s < 0.0 ? "back" : "ahead") +
                        " by " + ShortText(std::abs(step_s)) +
                        " s: its stamps go on as if it had not"};
}

}  // namespace gluevo::vo::internal
