#pragma once

#include "gluevo/vo/pipeline/frontend_config.h"
#include "gluevo/vo/pipeline/odometry_options.h"

namespace gluevo::vo {

/// All that odometry can be told. Values for a kind of data: PresetConfig() in presets.h.
struct OdometryConfig {
  FrontEndConfig frontend;
  OdometryOptions odometry;
  /// Of the networks; 0: one a processor. Results are the same for any number.
  int threads = 0;

  /// Throws Error naming the option.
  void Validate() const;
};

}  // namespace gluevo::vo
