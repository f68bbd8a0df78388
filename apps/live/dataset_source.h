#pragma once

#include <cstddef>

#include "frame_source.h"
#include "gluevo/vo/io/dataset.h"

namespace gluevo::apps {

struct DatasetSourceOptions {
  double pace = 1.0;  ///< So many seconds of the data set a second.
  /// How often it is gone through, every second time backwards, so that the path goes on. More than
  /// once without readings of an inertial unit, which know one direction only.
  int rounds = 1;
  bool gives_readings = false;
};

/// A data set as if it happened now: each image comes at its time, decoded before, as a camera
/// would give it. An image for which reading was too late is passed over.
class DatasetSource final : public LiveSource {
 public:
  /// The data set must outlive it.
  DatasetSource(const vo::Dataset& dataset, const DatasetSourceOptions& options, SourceClock clock);

  SourceEvent Next() override;
  int64_t Now() const override;
  SourceCounts counts() const override { return counts_; }

  /// In all rounds.
  std::size_t frames() const { return frames_; }

 private:
  std::size_t IndexOf(std::size_t frame) const;
  int64_t StampOf(std::size_t frame) const;
  /// On the source's clock.
  int64_t DueAt(int64_t stamp_ns) const;
  /// False where it is not that time yet.
  bool Wait(int64_t stamp_ns) const;
  void ReadNext(SourceEvent& event);
  SourceEvent GiveReadings(int64_t last_ns);

  const vo::Dataset& dataset_;
  DatasetSourceOptions options_;
  SourceClock clock_;
  std::size_t frames_;
  int64_t first_ns_;
  int64_t start_ns_;  // When that happened, on the source's clock.
  std::size_t next_ = 0;
  std::size_t next_reading_ = 0;
  std::optional<vo::StereoFrame> image_;  // The next frame, decoded.
  bool awaits_reading_ = false;           // The one beyond the last frame.
  SourceCounts counts_;
};

}  // namespace gluevo::apps
