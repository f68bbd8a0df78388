#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "command_line.h"
#include "gluevo/nn/lightglue.h"
#include "gluevo/vo/pipeline/networks.h"

namespace gluevo::apps {

/// Which networks a command runs, and on how many threads (0: one a processor).
void AddNetworkOptions(CLI::App& command, vo::NetworkFiles& files, int& threads);

/// What finds keypoints.
void AddFeaturesOption(CLI::App& command, std::string& features);
/// What matches them; empty for what goes with the features.
void AddMatcherOption(CLI::App& command, std::string& matcher);

void AddLightGlueOptions(CLI::App& command, nn::LightGlueOptions& options);

void AddKeypointOptions(CLI::App& command, vo::KeypointOptions& options);
/// The same where no preset sets them: a threshold that is not given is what suits the features.
void AddKeypointOptions(CLI::App& command, std::optional<float>& threshold, int& max_keypoints);

/// The files and folders that hold weights, as CheckOutputsAreNoInputs takes them.
std::vector<std::filesystem::path> WeightsInputs(const vo::NetworkFiles& files);

}  // namespace gluevo::apps
