#include "loop_options.h"

#include <CLI/CLI.hpp>

#include "gluevo/nn/option_error.h"
#include "option_group.h"

namespace gluevo::apps {

void AddLoopOptions(CLI::App& command, vo::LoopConfig& config, std::filesystem::path& save_map,
                    vo::MapCullingOptions& culling) {
  OptionGroup loops(command, "Loops");
  loops.AddSwitch(
      "--loops", config.is_on,
      "on: recognise places that were seen before, and write trajectory_optimized, which fits "
      "them; the other results stay as they are without. Where nothing asks for loops a run that "
      "cannot have them goes on without");
  loops.Add("--codebook", config.codebook,
            "Of places, made by gluevo codebook; without one that of the built-in SuperPoint");
  loops.Add("--save-map", save_map,
            "File to write the map to, for --load-map and gluevo localize: key frames with their "
            "keypoints and poses, and the loops between them; turns --loops on");
  loops.Add(
      "--load-map", config.load_map,
      "Come back to the places of such a file, too: trajectory_optimized is then in the map's "
      "frame from where the first of them is seen; with --save-map the map goes on growing; "
      "turns --loops on");
  loops.Add("--loop-interval", config.options.interval_s,
            "A key frame is kept for coming back to at most this often, seconds");
  loops.Add("--loop-min-age", config.options.min_age_s,
            "Places are not compared with those of the last so many seconds");
  loops.Add("--loop-candidates", config.options.max_candidates,
            "So many of the similar places are verified by the network");
  loops.AddSwitch("--final-adjustment", config.has_final_adjustment,
                  "on: with --loops on, adjust all key frames and points together in the end; kept "
                  "where it lowers the error of views that took no part");
  AddCullingOption(loops, culling);
}

void AddCullingOption(OptionGroup& group, vo::MapCullingOptions& culling) {
  group.AddSwitch(
      "--cull-map", culling.is_on,
      "on: a map keeps no key frame whose points three older ones show, and so grows with the "
      "space that was seen, not with time");
}

bool SettleLoops(CLI::App& command, bool is_default, const std::filesystem::path& save_map,
                 vo::LoopConfig& config) {
  CLI::Option* const loops = command.get_option("--loops");
  const bool has_map = !save_map.empty() || !config.load_map.empty();
  const bool is_said = loops->count() > 0;
  if (is_said && !config.is_on && has_map) {
    throw OptionError(
        "--loops off leaves nothing for --save-map and --load-map: expected --loops on");
  }
  if (is_said && !config.is_on && config.has_final_adjustment) {
    throw OptionError("--final-adjustment on is of what loops keep: expected --loops on");
  }
  const bool is_asked = (is_said && config.is_on) || has_map || config.has_final_adjustment ||
                        command.get_option("--codebook")->count() > 0;
  SetLoops(command, is_said ? config.is_on : is_asked || is_default, config);
  return is_asked;
}

void SetLoops(CLI::App& command, bool is_on, vo::LoopConfig& config) {
  config.is_on = is_on;
  command.get_option("--loops")->capture_default_str();  // What records of the run say.
}

}  // namespace gluevo::apps
