// gluevo live: stereo odometry as it happens.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "command_line/message.h"
#include "command_line/value_checks.h"
#include "commands.h"
#include "distinct_outputs.h"
#include "earlier_results.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/option_error.h"
#include "gluevo/vo/io/calibration.h"
#include "gluevo/vo/io/output_directory.h"
#include "interruption.h"
#include "live/camera_source.h"
#include "live/dataset_source.h"
#include "live/live_run.h"
#include "options/frontend_options.h"
#include "options/loop_options.h"
#include "processors.h"
#include "run_setup.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

struct LiveArguments : RunArguments {
  std::vector<std::string> sources;
  double pace = 1.0;
  int rounds = 1;
  std::optional<double> duration_s;
  double give_up_s = 30.0;
  vo::LiveOptions pipeline;
  std::string udp;
  fs::path socket;
  bool is_quiet = false;
  std::optional<std::string> view;
  std::string view_token;
};

void AddLiveOptions(CLI::App& command, LiveArguments& arguments) {
  command
      .add_option(
          "SOURCE", arguments.sources,
          "Folder of a data set, or cameras: /dev/video0 (V4L2) or a pipeline of GStreamer, "
          "left and right, or one that shows both side by side")
      ->required()
      ->expected(1, 2);
  AddRunArguments(command, arguments);
  DescribeLagByClock(command);
  command.add_option("--pace", arguments.pace, "Of a data set: so many of its seconds a second")
      ->check(Above(0.0))
      ->capture_default_str();
  command
      .add_option("--rounds", arguments.rounds,
                  "How often a data set is gone through, every second time backwards; more than "
                  "once without its inertial unit")
      ->check(Within(1, 1'000'000))
      ->capture_default_str();
  command
      .add_option("--duration", arguments.duration_s,
                  "End after so many seconds: of a data set its own, so that --pace shortens "
                  "them")
      ->check(Above(0.0));
  command
      .add_option("--give-up", arguments.give_up_s,
                  "A camera that is gone is waited for so long, seconds")
      ->check(Above(0.0))
      ->capture_default_str();
  command
      .add_option(
          "--queue", arguments.pipeline.queue_frames,
          "So many frames wait at most while one is tracked; for more the oldest is dropped")
      ->check(Within(1, 1000))
      ->capture_default_str();
  command
      .add_option(
          "--max-age", arguments.pipeline.max_age_s,
          "A frame that is older, seconds, when its turn comes is dropped where a newer one "
          "waits")
      ->check(Above(0.0))
      ->capture_default_str();
  command.add_option("--udp", arguments.udp,
                     "HOST:PORT to send each pose to, a line of TUM's form a datagram");
  command.add_option("--socket", arguments.socket,
                     "Unix socket to make, from which any number of readers get the lines");
  command
      .add_option("--view", arguments.view,
                  "Show it in a browser on this machine: PORT (8080 where none is given), or "
                  "ADDRESS:PORT for others, who then need the token")
      ->expected(0, 1)
      ->default_str("8080");
  command.add_option("--view-token", arguments.view_token,
                     "Whoever looks must have it; default: one that is printed, where the view is "
                     "for other machines");
  command.add_flag("--quiet", arguments.is_quiet, "Print no poses");
  command.footer(
      "Prints a line for each pose, t x y z qx qy qz qw, as it comes, and at the end (Ctrl-C ends "
      "it) writes what gluevo run writes.\nExamples:\n  gluevo live data/V1_01_easy -o results\n"
      "  gluevo live /dev/video0 /dev/video2 --calibration camchain.yaml -o results");
}

bool IsCamera(const std::string& source) {
  std::error_code code;
  return source.find('!') != std::string::npos || source.starts_with("/dev/") ||
         (source.find_first_not_of("0123456789") == std::string::npos && !fs::exists(source, code));
}

void CheckArguments(const LiveArguments& arguments) {
  const bool is_camera = IsCamera(arguments.sources.front());
  if (arguments.sources.size() > 1 && (!is_camera || !IsCamera(arguments.sources.back()))) {
    throw OptionError("two sources are left and right camera; expected one data set, got " +
                      Quoted(arguments.sources.front()) + " and " +
                      Quoted(arguments.sources.back()));
  }
  if (is_camera && arguments.frames.calibration.empty()) {
    throw OptionError("cameras have no calibration of their own; expected --calibration");
  }
  const std::string& imu = arguments.frames.imu;
  const bool needs_imu = (imu != "auto" && imu != "off") || arguments.places.has_imu_rate ||
                         arguments.config.odometry.inertial.estimate_time_offset;
  if (needs_imu && (is_camera || arguments.rounds > 1)) {
    throw OptionError(
        std::string(is_camera ? "cameras come without inertial unit"
                              : "--rounds goes backwards, too, where no inertial unit is right") +
        "; expected --imu off, no --imu-rate and no --estimate-time-offset");
  }
  std::vector<fs::path> inputs = InputsOf(arguments);
  inputs.emplace_back(is_camera ? fs::path() : fs::path(arguments.sources.front()));
  std::vector<fs::path> outputs = OutputsOf(arguments);
  outputs.push_back(arguments.socket);
  CheckOutputsAreDistinct(outputs);
  CheckOutputsAreNoInputs(outputs, inputs);
  CheckReplacesOnlyResults(arguments.places, {}, is_camera ? "" : arguments.sources.front());
}

// The rig of what the cameras show, as if it were a data set's.
vo::Dataset DescribeCameras(const LiveArguments& arguments, const cv::Size& size) {
  const vo::Calibration calibration = vo::ReadCalibration(
      arguments.frames.calibration, std::array<int, 2>{size.width, size.height});
  for (const vo::Camera& camera : calibration.rig.cameras) {
    if (camera.width != size.width || camera.height != size.height) {
      throw Error(calibration.files.front().string() + ": is of images of " +
                  std::to_string(camera.width) + "x" + std::to_string(camera.height) + ", " +
                  arguments.sources.front() + " gives " + std::to_string(size.width) + "x" +
                  std::to_string(size.height) +
                  (arguments.sources.size() == 1 ? " (of two side by side)" : ""));
    }
  }
  vo::Dataset dataset;
  dataset.root = arguments.sources.front();
  dataset.format = vo::DatasetFormat::kPlain;
  dataset.rig = calibration.rig;
  dataset.calibration = calibration.files.front();
  dataset.notes = calibration.notes;
  dataset.warnings = calibration.warnings;
  return dataset;
}

// Where they are cameras, those too.
vo::Dataset OpenSource(const LiveArguments& arguments, std::unique_ptr<CameraSource>& cameras) {
  if (!IsCamera(arguments.sources.front())) {
    return vo::OpenDataset(arguments.sources.front(), MakeDatasetOptions(arguments.frames));
  }
  cameras =
      std::make_unique<CameraSource>(CameraSourceOptions{arguments.sources, arguments.give_up_s},
                                     OpenVideoDevice, SteadySourceClock());
  return DescribeCameras(arguments, cameras->image_size());
}

// The map as it is by now, for the view's button.
std::string SaveMap(const RunPlaces& places, const RunRecords& records,
                    const std::vector<vo::WeightsRecord>& weights) {
  RunPlaces here = places;
  here.saved_map = places.saved_map.empty() ? places.folder / "places.map" : places.saved_map;
  try {
    WritePlaces(here, records, records.loops->closer().Optimized(), vo::FeaturesOf(weights));
  } catch (const Error& error) {
    return error.what();
  }
  return "saved " + here.saved_map.string();
}

void Live(LiveArguments& arguments, CLI::App& command, const std::map<std::string, bool>& given) {
  const Interruption interruption;
  // Places take memory for as long as it runs.
  arguments.needs_loops =
      SettleLoops(command, /*is_default=*/false, arguments.places.saved_map, arguments.loops);
  arguments.places.has_loops = arguments.loops.is_on;
  CheckArguments(arguments);
  const std::optional<ViewAddress> view_address =
      ViewAddressOf(arguments.view, arguments.view_token);
  std::vector<std::unique_ptr<LinePublisher>> publishers;
  if (!arguments.udp.empty()) {
    publishers.push_back(MakeUdpPublisher(arguments.udp));
  }
  UseProcessors(arguments.processors);
  const int threads = ThreadsOf(arguments.config.threads);
  nn::ThreadPool pool(threads);
  UseKernelThreads(KernelThreads(arguments, threads));

  RunSetup setup;
  std::unique_ptr<CameraSource> cameras;
  setup.dataset = OpenSource(arguments, cameras);
  if (arguments.rounds > 1) {
    arguments.frames.imu = "off";
    setup.dataset.groundtruth.reset();  // It does not go backwards.
  }
  SetUpImu(arguments, setup);
  PrintNotes(setup.dataset);
  ApplyPresetAndWarn(command, given, /*is_replay=*/false, arguments, setup);
  UseLagByClock(command, arguments.config.frontend.learned);
  SetUpFrontEnd(command, pool, arguments, setup);
  const vo::OutputDirectory output(arguments.places.folder);
  CheckPlaces(arguments.places);
  vo::Odometry odometry = MakeOdometry(arguments, setup);
  RunRecords records{.strip = StripRecorder(/*frames=*/0),
                     .diagnosis = vo::Diagnosis(setup.dataset.rig, setup.method != "klt"),
                     .loops = std::move(setup.loops),
                     .extracted = setup.extracted};
  records.metrics.KeepOnDisk(arguments.places.folder);
  if (!arguments.socket.empty()) {
    publishers.push_back(MakeSocketPublisher(arguments.socket));
  }
  std::unique_ptr<ViewFeed> view;
  if (view_address) {
    view = std::make_unique<ViewFeed>(*view_address, setup.dataset.rig, records.loops.has_value());
    std::cerr << "view: " << view->url() << '\n';
  }
  // A data set begins to happen only now.
  std::unique_ptr<DatasetSource> played;
  if (!cameras) {
    played = std::make_unique<DatasetSource>(
        setup.dataset, DatasetSourceOptions{arguments.pace, arguments.rounds, setup.uses_imu},
        SteadySourceClock());
  }
  LiveSource& source = cameras ? static_cast<LiveSource&>(*cameras) : *played;
  LiveRun run(
      {source, records, std::move(publishers), !arguments.is_quiet, arguments.duration_s,
       std::move(view), [&] { return SaveMap(arguments.places, records, setup.networks.records); }},
      std::move(odometry), arguments.pipeline);
  const LiveEnd live = run.Run();
  if (records.trajectory.empty()) {
    throw Error(!live.end.failure.empty() ? live.end.failure
                                          : arguments.sources.front() + ": no frame was tracked");
  }

  // Ending is what people do to cameras.
  EarlyEnd end = live.end;
  end.signal = cameras ? 0 : end.signal;
  RunMetrics::Context context =
      MakeContext(command, arguments, setup, records, run.odometry(), end, threads);
  context.live = run.record();
  context.frames_asked = played ? played->frames() : records.trajectory.size();
  FinishRun(arguments.places, setup.dataset, arguments.sources.front(), records, context,
            std::cerr);
  records.metrics.CheckThatSomethingWasTracked(context);
}

}  // namespace

void AddLiveCommand(CLI::App& app) {
  CLI::App* const command = app.add_subcommand(
      "live", "Stereo odometry as it happens: from cameras, or a data set at its own pace");
  const auto arguments = std::make_shared<LiveArguments>();
  AddLiveOptions(*command, *arguments);
  command->callback([arguments, command] {
    const std::map<std::string, bool> given = TakeConfigFile(*command, *arguments);
    Live(*arguments, *command, given);
  });
}

}  // namespace gluevo::apps
