#pragma once

#include <memory>
#include <string>

#include "command_line.h"
#include "gluevo/nn/superpoint.h"
#include "gluevo/nn/thread_pool.h"
#include "gluevo/vo/frontend/frontend.h"
#include "gluevo/vo/frontend/klt_frontend.h"
#include "gluevo/vo/frontend/learned_frontend.h"
#include "gluevo/vo/frontend/superpoint_frontend.h"
#include "network_options.h"

namespace gluevo::apps {

/// Which front end a run has, as its options say.
struct FrontEndArguments {
  std::string method = "superglue";
  std::string matcher = "superglue";
  NetworkOptions networks;
  nn::SuperPointOptions superpoint = {.keypoint_threshold = 0.005F, .max_keypoints = 500};
  std::string refine = "lk";  ///< none, subpixel or lk.
  vo::LearnedFrontEndOptions learned;
  vo::SuperPointFrontEndOptions stereo;  ///< Its ratio; the rest is the others'.
  vo::KltOptions klt;
};

void AddFrontEndOptions(CLI::App& command, FrontEndArguments& arguments);

/// Gives the command's options the method's own values where neither command line nor
/// configuration gave any.
void ApplyMethodDefaults(CLI::App& command, const FrontEndArguments& arguments);

/// The networks that the front end runs; none for klt. Throws Error as LoadNetworks does.
Networks LoadFrontEndNetworks(const FrontEndArguments& arguments);

/// The pool must outlive it. Throws Error for options out of their range.
std::unique_ptr<vo::FrontEnd> MakeFrontEnd(const FrontEndArguments& arguments,
                                           const vo::StereoRig& rig, const Networks& networks,
                                           nn::ThreadPool& pool);

}  // namespace gluevo::apps
