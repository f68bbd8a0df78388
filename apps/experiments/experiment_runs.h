#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiment_plan.h"

namespace gluevo::apps {

/// What became of a planned run.
struct RunOutcome {
  enum class Status {
    kDone,     ///< Ran now.
    kKept,     ///< Its result was there.
    kFailed,   ///< See `reason`.
    kMissing,  ///< Its data set is not there.
  };
  PlannedRun run;
  Status status = Status::kFailed;
  std::string reason;              ///< Why it failed: one line.
  nlohmann::ordered_json metrics;  ///< metrics.json; null where there is none.

  bool HasResult() const { return status == Status::kDone || status == Status::kKept; }
};

struct ExperimentSchedule {
  std::filesystem::path output;  ///< The runs' folders are below it.
  int jobs = 1;                  ///< Runs at once, at most one a thread.
  int threads = 1;               ///< Of all runs together.
};

/// Runs what has no result yet, each in a process of its own, and reads all results, in the order
/// planned. Tells on stderr how far it is. Throws Error where a folder cannot be written.
std::vector<RunOutcome> RunExperiment(const std::vector<PlannedRun>& runs,
                                      const ExperimentSchedule& schedule);

}  // namespace gluevo::apps
