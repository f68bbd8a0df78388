#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include "gluevo/vo/core/trajectory.h"
#include "gluevo/vo/frontend/match_store.h"
#include "gluevo/vo/frontend/network_memo.h"
#include "gluevo/vo/io/dataset.h"
#include "gluevo/vo/mapping/loop_recorder.h"
#include "gluevo/vo/mapping/map.h"
#include "gluevo/vo/pipeline/diagnosis.h"
#include "gluevo/vo/pipeline/odometry.h"
#include "report/strip.h"
#include "run_metrics.h"

namespace gluevo::apps {

/// What gathers over the frames of a run.
struct RunRecords {
  RunMetrics metrics;
  StripRecorder strip;
  vo::Diagnosis diagnosis;
  std::optional<vo::MatchStoreWriter> matches;
  std::optional<vo::MapRecorder> map;
  std::optional<vo::LoopRecorder> loops;
  std::shared_ptr<const vo::ExtractorMemo> extracted;  ///< The front end's, for loops; or null.
  vo::Trajectory trajectory;
  vo::Trajectory keyframes;
};

struct FrameSource {
  const vo::Dataset& dataset;
  bool reads_images = true;
  bool is_strict = false;  ///< A frame that cannot be read ends the run, else it is left out.
  /// Whether the next frames are read, and what is made of those before, while one is tracked: on
  /// two more threads, and one for loops. Results are the same.
  bool overlaps = true;
};

/// Why a run ended before its last frame; empty and 0 where it did not.
struct EarlyEnd {
  std::string failure;  ///< What failed.
  int signal = 0;       ///< That asked for it.
};

/// Throws Error where an image has a name that a map cannot hold.
void CheckNamesForMap(const vo::Dataset& dataset);

/// Takes all frames through the odometry. What it has done when it ends early is in `records`.
EarlyEnd ProcessFrames(const FrameSource& source, vo::Odometry& odometry, RunRecords& records);

}  // namespace gluevo::apps
