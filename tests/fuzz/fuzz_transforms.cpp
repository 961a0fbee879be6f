// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/transforms_file.h"
#include "tests/fuzz/fuzz_files.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace relight;
  const auto& folder = fuzz::Written(data, size, {"transforms.json"});
  return fuzz::Survives([&] {
    return ReadTransforms(
        folder / "transforms.json", fuzz::Photos(), UnknownPhotos::kLeaveOut);
  });
}
