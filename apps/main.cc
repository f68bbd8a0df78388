// The command gluevo.

#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>

#include "commands.h"
#include "interruption.h"
#include "standard_streams.h"

namespace {

int Run(CLI::App& app, int argc, char** argv) {
  int status = 0;
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    constexpr int kBadUsage = 2;
    status = app.exit(error) == 0 ? 0 : kBadUsage;
  }
  gluevo::apps::CheckStandardOutput();
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  gluevo::apps::PrepareStandardStreams();
  CLI::App app("Stereo visual SLAM with learned features on any CPU", "gluevo");
  app.set_version_flag("--version", "gluevo " GLUEVO_VERSION);
  app.require_subcommand(1);
  app.footer("Example:\n  gluevo run data/V1_01_easy -o results/V1_01");
  gluevo::apps::AddRunCommand(app);
  gluevo::apps::AddExtractCommand(app);
  gluevo::apps::AddMatchCommand(app);
  gluevo::apps::AddEvaluateCommand(app);
  gluevo::apps::AddCalibrationCommand(app);
  gluevo::apps::AddCodebookCommand(app);
  gluevo::apps::AddDoctorCommand(app);
  gluevo::apps::AddExperimentCommand(app);
  gluevo::apps::AddSimulateCommand(app);
  gluevo::apps::AddBenchCommand(app);
  gluevo::apps::AddWeightsCommand(app);
  try {
    return Run(app, argc, argv);
  } catch (const gluevo::apps::Interrupted& interrupted) {
    std::cerr << "gluevo: interrupted\n";
    return interrupted.exit_code();
  } catch (const std::exception& error) {
    std::cerr << "gluevo: error: " << error.what() << '\n';
    return 1;
  }
}
