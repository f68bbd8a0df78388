#pragma once

#include "command_line.h"

// Each subcommand of `gluevo` is one file that adds itself.
namespace gluevo::apps {

void AddBenchCommand(CLI::App& app);
void AddCalibrationCommand(CLI::App& app);
void AddCodebookCommand(CLI::App& app);
void AddDoctorCommand(CLI::App& app);
void AddEvaluateCommand(CLI::App& app);
void AddExperimentCommand(CLI::App& app);
void AddExtractCommand(CLI::App& app);
void AddLocalizeCommand(CLI::App& app);
void AddMapCommand(CLI::App& app);
void AddMatchCommand(CLI::App& app);
void AddRunCommand(CLI::App& app);
void AddLiveCommand(CLI::App& app);
void AddSimulateCommand(CLI::App& app);
void AddWeightsCommand(CLI::App& app);

}  // namespace gluevo::apps
