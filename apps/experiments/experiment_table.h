#pragma once

#include <string>
#include <vector>

#include "experiment_runs.h"

namespace gluevo::apps {

/// The results of an experiment, a row for each planned run.
struct ExperimentTable {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;  ///< Rounded, "-" where there is no figure.
  std::vector<std::string> notes;              ///< What the columns do not say, a line each.
};

/// For people: the best of each figure is not marked, as figures of one row belong together.
ExperimentTable MakeTable(const std::vector<RunOutcome>& outcomes);

std::string TableAsMarkdown(const std::string& title, const ExperimentTable& table);

/// For programs: all digits, the same columns whatever the outcome; a row for each planned run.
std::string OutcomesAsCsv(const std::vector<RunOutcome>& outcomes);
std::string OutcomesAsJson(const std::string& title, const std::vector<RunOutcome>& outcomes);

}  // namespace gluevo::apps
