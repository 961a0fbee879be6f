// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/realitycapture_files.h"
#include "tests/fuzz/fuzz_files.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace relight;
  const auto& folder = fuzz::Written(data, size, {"cameras.csv"});
  return fuzz::Survives([&] {
    return ReadRealityCapture(
        folder / "cameras.csv", fuzz::Photos(), UnknownPhotos::kLeaveOut);
  });
}
