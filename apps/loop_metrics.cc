#include "loop_metrics.h"

#include <algorithm>
#include <iomanip>
#include <map>
#include <sstream>

#include "evaluation_json.h"
#include "gluevo/nn/error.h"

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
  if (!attempt.is_closed) {
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

}  // namespace

LoopOutcome CloseLoops(const vo::LoopRecorder& recorder,
                       const std::optional<vo::Trajectory>& groundtruth) {
  LoopOutcome outcome{.attempts = recorder.closer().attempts(), .optimized = recorder.Optimized()};
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
  if (loops.evaluation) {
    json["optimized"] = Json::object();
    AddEvaluation(*loops.evaluation, json["optimized"]);
  }
}

std::string TextOfLoops(const LoopOutcome& loops) {
  std::ostringstream text;
  text << "loops: " << loops.closed << " closed of " << loops.attempts.size() << " tried";
  if (loops.segments_joined > 0) {
    text << ", " << loops.segments_joined << " segments joined (" << loops.linked_frames
         << " frames hang together)";
  }
  if (loops.frames_in_map) {
    text << "; " << *loops.frames_in_map << " frames are in the map";
  }
  if (loops.evaluation) {
    text << std::fixed << std::setprecision(4) << "; ATE with loops " << loops.evaluation->ate_se3_m
         << " m (SE3)";
  }
  text << '\n';
  return text.str();
}

}  // namespace gluevo::apps
