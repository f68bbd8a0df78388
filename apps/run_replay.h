#pragma once

#include <string>

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

/// Name and checksum of the weights of a network ("superpoint", "superglue") of the stored run.
vo::WeightsRecord ReplayedWeights(const vo::MatchStoreReader& store, const std::string& network);

}  // namespace gluevo::apps
