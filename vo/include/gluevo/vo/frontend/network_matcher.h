#pragma once

#include <memory>

#include "gluevo/nn/aliked.h"
#include "gluevo/nn/lightglue.h"
#include "gluevo/nn/superglue.h"
#include "gluevo/nn/superpoint.h"
#include "gluevo/nn/thread_pool.h"
#include "gluevo/vo/frontend/matcher.h"

namespace gluevo::vo {

/// SuperPoint as a FeatureExtractor. The pool must outlive it. Throws Error for bad options.
std::unique_ptr<FeatureExtractor> MakeSuperPointExtractor(
    std::shared_ptr<const nn::SuperPoint> network, const nn::SuperPointOptions& options,
    nn::ThreadPool& pool);

/// ALIKED as a FeatureExtractor. The pool must outlive it. Throws Error for bad options.
std::unique_ptr<FeatureExtractor> MakeAlikedExtractor(std::shared_ptr<const nn::Aliked> network,
                                                      const nn::AlikedOptions& options,
                                                      nn::ThreadPool& pool);

/// SuperGlue as a Matcher. The pool must outlive it. Throws Error for bad options.
std::unique_ptr<Matcher> MakeSuperGlueMatcher(std::shared_ptr<const nn::SuperGlue> network,
                                              int sinkhorn_iterations, nn::ThreadPool& pool);

/// LightGlue as a Matcher, its match_threshold being that of each call. Weights that cannot tell
/// when to stop run all layers whatever the options say. The pool must outlive it. Throws Error for
/// bad options.
std::unique_ptr<Matcher> MakeLightGlueMatcher(std::shared_ptr<const nn::LightGlue> network,
                                              const nn::LightGlueOptions& options,
                                              nn::ThreadPool& pool);

/// Mutual nearest neighbours by descriptor as a Matcher; a confidence is the cosine.
std::unique_ptr<Matcher> MakeNearestNeighborMatcher();

}  // namespace gluevo::vo
