#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/vo/core/trajectory.h"
#include "gluevo/vo/evaluation/evaluation.h"
#include "gluevo/vo/evaluation/loop_evaluation.h"
#include "gluevo/vo/mapping/global_adjustment.h"
#include "gluevo/vo/mapping/loop_recorder.h"

namespace gluevo::apps {

/// What became of a run's loops.
struct LoopOutcome {
  std::vector<vo::Rigid3> keyframe_poses;  ///< Of all that is kept, in the end.
  std::vector<vo::LoopAttempt> attempts;
  int closed = 0;
  int segments_joined = 0;  ///< That hang together with an older one.
  vo::Trajectory optimized;
  /// Of the optimised poses of the largest part that odometry and loops hold together, where there
  /// is truth.
  std::optional<vo::Evaluation> evaluation;
  std::size_t linked_frames = 0;  ///< In that part.
  /// Recall and precision, where there is truth and no map that has another one.
  std::optional<vo::LoopEvaluation> quality;
  std::optional<vo::GlobalAdjustment> adjustment;  ///< Where one was asked for.
  /// Linked with a loaded map; nothing where none was loaded.
  std::optional<std::size_t> frames_in_map;
};

/// Solves the pose graph, and adjusts all key frames together where that is asked for.
LoopOutcome CloseLoops(const vo::LoopRecorder& recorder, bool has_final_adjustment,
                       const std::optional<vo::Trajectory>& groundtruth);

/// Adds "loops", "loops_rejected", "segments_joined", "optimized" and the like.
void AddLoops(const LoopOutcome& loops, nlohmann::ordered_json& json);
/// A line or two for people; none where no place was like another.
std::string TextOfLoops(const LoopOutcome& loops);

}  // namespace gluevo::apps
