#include "loop_options.h"

#include "command_line/value_checks.h"
#include "option_group.h"

namespace gluevo::apps {

void AddLoopOptions(CLI::App& command, vo::LoopConfig& config) {
  OptionGroup loops(command, "Loops");
  loops
      .Add("--loops", config.is_on,
           "on: recognise places that were seen before, and write trajectory_optimized, which fits "
           "them; the other results stay as they are without")
      ->check(OneOf({"off", "on"}))
      ->default_str("off");
  loops.Add("--codebook", config.codebook,
            "Of places, made by gluevo codebook; without one that of the built-in SuperPoint");
  loops.Add("--loop-interval", config.options.interval_s,
            "A key frame is kept for coming back to at most this often, seconds");
  loops.Add("--loop-min-age", config.options.min_age_s,
            "Places are not compared with those of the last so many seconds");
  loops.Add("--loop-candidates", config.options.max_candidates,
            "So many of the most similar places are verified");
}

}  // namespace gluevo::apps
