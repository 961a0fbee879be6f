// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/realitycapture_files.h"
#include "tests/fuzz/fuzz_files.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace relight;
  const auto& folder = fuzz::Written(data, size, {"view_10.xmp"});
  return fuzz::Survives([&] {
    return ReadRealityCapture(
        folder / "view_10.xmp", fuzz::Photos(), UnknownPhotos::kLeaveOut);
  });
}
