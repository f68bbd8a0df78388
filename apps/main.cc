// The command gluevo.

#include <CLI/CLI.hpp>

#include "command_line/message.h"
#include "command_line/usage.h"
#include "command_line/value_checks.h"
#include "commands.h"
#include "interruption.h"
#include "kept_memory.h"

int main(int argc, char** argv) {
  gluevo::apps::KeepFreedMemory();
  CLI::App app("Stereo visual SLAM with learned features on any CPU", "gluevo");
  app.set_version_flag("--version", "gluevo " GLUEVO_VERSION);
  app.require_subcommand(1);
  app.footer("Example:\n  gluevo run data/V1_01_easy -o results/V1_01");
  gluevo::apps::AddRunCommand(app);
  gluevo::apps::AddLiveCommand(app);
  gluevo::apps::AddExtractCommand(app);
  gluevo::apps::AddMatchCommand(app);
  gluevo::apps::AddEvaluateCommand(app);
  gluevo::apps::AddCalibrationCommand(app);
  gluevo::apps::AddCodebookCommand(app);
  gluevo::apps::AddDoctorCommand(app);
  gluevo::apps::AddExperimentCommand(app);
  gluevo::apps::AddLocalizeCommand(app);
  gluevo::apps::AddMapCommand(app);
  gluevo::apps::AddSimulateCommand(app);
  gluevo::apps::AddBenchCommand(app);
  gluevo::apps::AddWeightsCommand(app);
  gluevo::apps::CheckAllValues(app);
  try {
    return gluevo::apps::RunCommandLine(app, argc, argv);
  } catch (const gluevo::apps::Interrupted& interrupted) {
    gluevo::apps::PrintMessage("gluevo", "interrupted");
    return interrupted.exit_code();
  }
}
