#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace gluevo::vo::internal {

/// Watches the stamps of a sensor as they arrive: gives them on in order, whatever its clock does.
class StampWatch {
 public:
  /// `sensor`: for messages, "camera".
  explicit StampWatch(std::string sensor) : sensor_(std::move(sensor)) {}

  struct Judged {
    std::optional<int64_t> timestamp_ns;  ///< As it goes on; nothing where it is to be left out.
    std::string warning;                  ///< Where something begins; else empty.
  };
  /// The next stamp, and the time now on the same clock before any step. `other_shift_ns`: what is
  /// added to the stamps of another sensor, which may have the same clock.
  Judged Judge(int64_t stamp_ns, int64_t now_ns, int64_t other_shift_ns);

  int64_t shift_ns() const { return shift_ns_; }
  int64_t still() const { return still_; }
  int64_t back() const { return back_; }
  int64_t steps() const { return steps_; }

 private:
  Judged GoOn(int64_t stamp_ns, int64_t now_ns, int64_t other_shift_ns);

  std::string sensor_;
  bool has_last_ = false;
  int64_t last_ns_ = 0;       // As it was given on.
  int64_t last_now_ns_ = 0;   // When.
  int64_t least_age_ns_ = 0;  // Of stamps at their arrival, since the last step.
  int64_t shift_ns_ = 0;
  bool is_leaving_out_ = false;
  int64_t still_ = 0, back_ = 0, steps_ = 0;
};

}  // namespace gluevo::vo::internal
