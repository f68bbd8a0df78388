// The command gluevo.

#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>

#include "commands.h"

int main(int argc, char** argv) {
  CLI::App app("Stereo visual SLAM with learned features on any CPU", "gluevo");
  app.set_version_flag("--version", "gluevo " GLUEVO_VERSION);
  app.require_subcommand(1);
  app.footer("Example:\n  gluevo run data/V1_01_easy -o results/V1_01");
  gluevo::apps::AddRunCommand(app);
  gluevo::apps::AddExtractCommand(app);
  gluevo::apps::AddMatchCommand(app);
  gluevo::apps::AddEvaluateCommand(app);
  gluevo::apps::AddCalibrationCommand(app);
  gluevo::apps::AddDoctorCommand(app);
  gluevo::apps::AddExperimentCommand(app);
  gluevo::apps::AddSimulateCommand(app);
  gluevo::apps::AddBenchCommand(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    constexpr int kBadUsage = 2;
    return app.exit(error) == 0 ? 0 : kBadUsage;
  } catch (const std::exception& error) {
    std::cerr << "gluevo: error: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
