#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "command_line.h"
#include "gluevo/vo/frontend/match_store.h"
#include "gluevo/vo/io/dataset.h"
#include "gluevo/vo/pipeline/networks.h"

namespace gluevo::apps {

/// What is written into the file of --save-matches about the run.
vo::RunRecord MakeRunRecord(const CLI::App& command, const std::string& method,
                            const vo::Networks& networks);

/// The stored run's method. Throws Error where --method asks for another one.
std::string ReplayedMethod(const CLI::App& command, const vo::MatchStoreReader& store);

/// Takes --start, --count and --stride from the stored run where the command gives none of them: as
/// many frames as it got to, should it have ended early.
void SelectReplayedFrames(const CLI::App& command, const vo::MatchStoreReader& store, int& start,
                          int& count, int& stride);

/// Takes away the frames that the stored run could not read.
void LeaveOutReplayed(const vo::MatchStoreReader& store, vo::Dataset& dataset);

/// Names and checksums of the weights of the stored run's networks.
std::vector<vo::WeightsRecord> ReplayedWeights(const vo::MatchStoreReader& store);

/// Adds the weights of more networks that a replay of `store` runs to those of the stored run.
/// Throws Error naming both where one network would have two weights.
void AddReplayedWeights(const std::vector<vo::WeightsRecord>& more,
                        const std::filesystem::path& store,
                        std::vector<vo::WeightsRecord>& replayed);

/// What found keypoints in the stored run ("superpoint", "aliked"), and what matched them; empty
/// for methods without. Versions that did not know others have SuperPoint and SuperGlue.
std::string ReplayedFeatures(const vo::MatchStoreReader& store);
std::string ReplayedMatcher(const vo::MatchStoreReader& store);

}  // namespace gluevo::apps
