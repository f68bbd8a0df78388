#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/vo/core/imu.h"
#include "gluevo/vo/core/stereo_frame.h"

namespace gluevo::apps {

/// What a source gives next; nothing in any of it where there is nothing yet.
struct SourceEvent {
  std::optional<vo::StereoFrame> frame;
  std::vector<vo::ImuSample> readings;
  std::string warning;   ///< A sentence for people.
  std::string left_out;  ///< Why a frame cannot be read; it is `frame_index`.
  std::size_t frame_index = 0;
  bool is_end = false;
};

/// What a source did not give.
struct SourceCounts {
  int64_t frames_late = 0;      ///< Passed over since reading was too slow.
  int64_t cameras_gone = 0;     ///< How often a camera was gone.
  int64_t frames_unpaired = 0;  ///< Images of one camera without the other's.
};

/// Where stereo pairs come from as they happen.
class LiveSource {
 public:
  LiveSource() = default;
  LiveSource(const LiveSource&) = delete;
  LiveSource& operator=(const LiveSource&) = delete;
  virtual ~LiveSource() = default;

  /// Waits for what comes next, some tenths of a second at most. Throws Error where nothing more
  /// can come.
  virtual SourceEvent Next() = 0;
  /// The time now on the clock that stamps the frames, nanoseconds. Any thread may ask.
  virtual int64_t Now() const = 0;
  virtual SourceCounts counts() const { return {}; }
};

/// The time that a source lives in: the steady clock, or a test's.
struct SourceClock {
  std::function<int64_t()> now_ns;
  std::function<void(int64_t until_ns)> sleep_until;
};

SourceClock SteadySourceClock();

}  // namespace gluevo::apps
