#include "loop_metrics.h"

#include <algorithm>
#include <iomanip>
#include <map>
#include <sstream>
#include <utility>

#include "evaluation_json.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/core/text.h"

namespace gluevo::apps {
namespace {

using Json = nlohmann::ordered_json;

Json ToJson(const vo::LoopAttempt& attempt) {
  Json json = {{"query_s", static_cast<double>(attempt.query_ns) * 1e-9},
               {"candidate_s", static_cast<double>(attempt.candidate_ns) * 1e-9},
               {"similarity", attempt.similarity},
               {"matches", attempt.matches},
               {"inliers", attempt.inliers}};
  if (attempt.is_of_loaded_map) {
    json["of_loaded_map"] = true;
  }
  if (attempt.is_closed) {
    json["closed_s"] = static_cast<double>(attempt.closed_ns) * 1e-9;
  } else {
    json["reason"] = attempt.reason;
  }
  return json;
}

// The oldest one of those that are equally large.
vo::Trajectory LargestPart(const vo::Trajectory& trajectory, const std::vector<int>& parts) {
  std::map<int, vo::Trajectory> poses;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    poses[parts[i]].push_back(trajectory[i]);
  }
  return std::max_element(
             poses.begin(), poses.end(),
             [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); })
      ->second;
}

vo::LoopEvaluation QualityOf(const vo::LoopRecorder& recorder, const std::vector<vo::Rigid3>& poses,
                             const vo::Trajectory& groundtruth) {
  const std::vector<vo::LoopKeyframe>& keyframes = recorder.closer().keyframes();
  std::vector<vo::PlaceVisit> visits;
  visits.reserve(keyframes.size());
  for (const vo::LoopKeyframe& keyframe : keyframes) {
    visits.push_back({keyframe.timestamp_ns, keyframe.segment});
  }
  std::map<std::pair<int64_t, int64_t>, int64_t> closed_ns;
  for (const vo::LoopAttempt& attempt : recorder.closer().attempts()) {
    if (attempt.is_closed) {
      closed_ns[{attempt.candidate_ns, attempt.query_ns}] = attempt.closed_ns;
    }
  }
  std::vector<vo::BelievedLoop> loops;
  loops.reserve(recorder.closer().loops().size());
  for (const vo::Loop& loop : recorder.closer().loops()) {
    loops.push_back({loop.candidate, loop.query, loop.measurement.candidate_from_query,
                     poses[loop.candidate].Inverse() * poses[loop.query],
                     closed_ns.at({keyframes[loop.candidate].timestamp_ns,
                                   keyframes[loop.query].timestamp_ns})});
  }
  return vo::EvaluateLoops(visits, loops, groundtruth, {});
}

Json ToJson(const vo::LoopEvaluation& quality) {
  const auto number = [](const std::optional<double>& value) {
    return value ? Json(*value) : Json(nullptr);
  };
  Json json = {{"revisits", quality.revisits},
               {"found", quality.found},
               {"recall", number(quality.recall)},
               {"loops", quality.loops},
               {"wrong", quality.wrong},
               {"wrong_kept", quality.wrong_kept},
               {"precision", number(quality.precision)}};
  json["joins"] = Json::array();
  for (const vo::LoopEvaluation::Join& join : quality.joins) {
    json["joins"].push_back({{"segment", join.segment},
                             {"seen_s", static_cast<double>(join.seen_ns) * 1e-9},
                             {"joined_after_s", number(join.joined_after_seconds)}});
  }
  return json;
}

Json ToJson(const vo::GlobalAdjustment& adjustment) {
  return {{"kept", adjustment.is_kept},
          {"landmarks", adjustment.landmarks},
          {"observations", adjustment.observations},
          {"held_out", adjustment.held_out},
          {"held_out_error_before_px", adjustment.error_before_px},
          {"held_out_error_after_px", adjustment.error_after_px}};
}

}  // namespace

LoopOutcome CloseLoops(const vo::LoopRecorder& recorder, bool has_final_adjustment,
                       const std::optional<vo::Trajectory>& groundtruth) {
  LoopOutcome outcome{.keyframe_poses = recorder.closer().Optimized(),
                      .attempts = recorder.closer().attempts()};
  if (has_final_adjustment) {
    outcome.adjustment = recorder.Adjust(outcome.keyframe_poses, {});
    outcome.keyframe_poses = outcome.adjustment->world_from_body;
  }
  outcome.optimized = recorder.Follow(outcome.keyframe_poses);
  // Those of a loaded map were closed before.
  outcome.closed = static_cast<int>(
      std::count_if(outcome.attempts.begin(), outcome.attempts.end(),
                    [](const vo::LoopAttempt& attempt) { return attempt.is_closed; }));
  const std::vector<int> linked = recorder.LinkedSegments();
  outcome.segments_joined = recorder.JoinedSegments();
  if (recorder.has_loaded_map()) {
    outcome.frames_in_map = recorder.FramesInLoadedMap();
  }
  const vo::Trajectory part = LargestPart(outcome.optimized, linked);
  outcome.linked_frames = part.size();
  if (groundtruth) {
    if (!recorder.has_loaded_map()) {
      outcome.quality = QualityOf(recorder, outcome.keyframe_poses, *groundtruth);
    }
    try {
      outcome.evaluation = vo::Evaluate(part, *groundtruth, {});
    } catch (const Error&) {
      // The run's own evaluation has failed of the same, and says so.
      outcome.evaluation.reset();
    }
  }
  return outcome;
}

void AddLoops(const LoopOutcome& loops, Json& json) {
  json["loops"] = Json::array();
  json["loops_rejected"] = Json::array();
  for (const vo::LoopAttempt& attempt : loops.attempts) {
    json[attempt.is_closed ? "loops" : "loops_rejected"].push_back(ToJson(attempt));
  }
  json["loops_closed"] = loops.closed;
  json["segments_joined"] = loops.segments_joined;
  json["linked_frames"] = loops.linked_frames;
  if (loops.frames_in_map) {
    json["frames_in_map"] = *loops.frames_in_map;
  }
  if (loops.quality) {
    json["loop_evaluation"] = ToJson(*loops.quality);
  }
  if (loops.adjustment) {
    json["final_adjustment"] = ToJson(*loops.adjustment);
  }
  if (loops.evaluation) {
    json["optimized"] = Json::object();
    AddEvaluation(*loops.evaluation, json["optimized"]);
  }
}

std::string TextOfLoops(const LoopOutcome& loops) {
  if (loops.attempts.empty() && !loops.frames_in_map && !loops.adjustment &&
      (!loops.quality || loops.quality->revisits == 0)) {
    return "";
  }
  std::ostringstream text;
  text << "loops: " << loops.closed << " closed of " << loops.attempts.size() << " tried";
  if (loops.segments_joined > 0) {
    text << ", " << vo::Counted(loops.segments_joined, "segment") << " joined ("
         << vo::Counted(loops.linked_frames, "frame") << " hang together)";
  }
  if (loops.frames_in_map) {
    text << "; " << vo::Counted(*loops.frames_in_map, "frame")
         << (*loops.frames_in_map == 1 ? " is" : " are") << " in the map";
  }
  if (loops.evaluation) {
    text << std::fixed << std::setprecision(4) << "; ATE with loops " << loops.evaluation->ate_se3_m
         << " m (SE3)";
  }
  text << '\n';
  if (loops.quality && loops.quality->recall) {
    text << "places seen again: " << loops.quality->found << " of " << loops.quality->revisits
         << " found, " << vo::Counted(loops.quality->wrong, "wrong loop") << "\n";
  }
  if (loops.adjustment) {
    text << "final adjustment: " << std::setprecision(3) << loops.adjustment->error_before_px
         << " px at views held out, then " << loops.adjustment->error_after_px
         << " px: " << (loops.adjustment->is_kept ? "kept" : "not kept") << '\n';
  }
  return text.str();
}

}  // namespace gluevo::apps
