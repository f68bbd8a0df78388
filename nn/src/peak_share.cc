#include "gluevo/nn/peak_share.h"

#include "kernels/kernels.h"

namespace gluevo::nn {

double PeakShare::MeasurePeak() const {
  constexpr double kSeconds = 0.02;
  const kernels::Kernels& kernels = kernels::KernelsFor(isa_);
  const auto measure =
      precision_ == Precision::kBf16 ? kernels.peak_flops_bf16 : kernels.peak_flops;
  return threads_ * measure(kSeconds);
}

}  // namespace gluevo::nn
