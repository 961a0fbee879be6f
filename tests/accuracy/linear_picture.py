# SPDX-License-Identifier: Apache-2.0
"""Linear pictures and mattes. Debian: python3-numpy python3-openimageio."""
import sys

import numpy as np
import OpenImageIO as oiio


def load(path):
    """Rows x columns x channels; not by ImageBuf, which remembers a file written anew."""
    file = oiio.ImageInput.open(str(path))
    if file is None:
        sys.exit(f"{path}: {oiio.geterror()}")
    pixels, spec = file.read_image(format=oiio.FLOAT), file.spec()
    file.close()
    return pixels.astype(np.float64).reshape(spec.height, spec.width, -1)
