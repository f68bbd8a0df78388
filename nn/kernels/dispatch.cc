#include <cstdlib>

#include "gluevo/nn/error.h"
#include "kernels/kernels.h"
#include "kernels/reference.h"
#include "kernels/vectorized.h"

namespace gluevo::nn {
namespace {

std::string NamesOf(const std::vector<Isa>& isas) {
  std::string names;
  for (const Isa isa : isas) {
    names += (names.empty() ? "" : ", ") + IsaName(isa);
  }
  return names;
}

}  // namespace

std::string IsaName(Isa isa) {
  switch (isa) {
    case Isa::kReference:
      return "reference";
    case Isa::kPortable:
      return "portable";
    case Isa::kAvx2:
      return "avx2";
    case Isa::kAvx512:
      return "avx512";
    case Isa::kAvx512Bf16:
      return "avx512_bf16";
  }
  return "unknown";
}

std::vector<Isa> SupportedIsas() {
  std::vector<Isa> isas = {Isa::kReference};
  for (const kernels::Kernels* const table : kernels::VectorizedKernels()) {
    isas.push_back(table->isa);
  }
  return isas;
}

Isa ChooseIsa() {
  const std::vector<Isa> supported = SupportedIsas();
  const char* const wanted = std::getenv("GLUEVO_ISA");
  if (wanted == nullptr || *wanted == '\0') {
    return supported.back();
  }
  for (const Isa isa : supported) {
    if (IsaName(isa) == wanted) {
      return isa;
    }
  }
  throw Error(
      "GLUEVO_ISA=" + std::string(wanted) +
      " is not an instruction set that this CPU and this build support: " + NamesOf(supported));
}

namespace kernels {

const Kernels& KernelsFor(Isa isa) {
  if (isa == Isa::kReference) {
    return ReferenceKernels();
  }
  for (const Kernels* const table : VectorizedKernels()) {
    if (table->isa == isa) {
      return *table;
    }
  }
  throw Error("no kernels for " + IsaName(isa) + " on this CPU");
}

}  // namespace kernels
}  // namespace gluevo::nn
