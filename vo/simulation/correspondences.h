#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "renderer.h"

namespace gluevo::simulation {

/// The file that SimulationOptions::correspondences describes, of left images at `world_from_body`.
/// Throws Error where it cannot be written. `checkpoint`: see there, too.
void WriteCorrespondences(const std::filesystem::path& file, const Renderer& renderer,
                          const SimulatedWorld& world,
                          const std::vector<vo::Rigid3>& world_from_body,
                          const std::vector<int64_t>& times_ns, int threads,
                          const std::function<void()>& checkpoint = {});

}  // namespace gluevo::simulation
