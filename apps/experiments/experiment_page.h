#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiment_runs.h"
#include "experiment_table.h"

namespace gluevo::apps {

/// One self-contained HTML page (light and dark, readable on a phone, nothing loaded from
/// elsewhere): the table, and a small picture of each run's trajectory over ground truth that links
/// to the run's report or log. `output` is the experiment's folder, where the page will stand.
std::string ExperimentPage(const std::string& title, const ExperimentTable& table,
                           const std::vector<RunOutcome>& outcomes,
                           const std::filesystem::path& output);

}  // namespace gluevo::apps
