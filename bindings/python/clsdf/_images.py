"""Grids of medical images, whose axes may have any direction: of SimpleITK and nibabel."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _core
from ._complete import complete
from ._core import Grid
from ._error import Error
from ._frames import into_frame
from ._values import Samples

#: Space of NRRD: of SimpleITK's positions, and of nibabel's.
_of_itk, _of_nifti = "left-posterior-superior", "right-anterior-superior"


class Image(NamedTuple):
    """The geometry of an image: voxel (i, j, k) is at origin + direction @ ((i, j, k) * spacing)."""

    origin: npt.NDArray[np.float64]  #: (3,)
    spacing: npt.NDArray[np.float64]  #: (3,)
    size: tuple[int, int, int]  #: voxels along i, j, k
    direction: npt.NDArray[np.float64]  #: (3, 3), a rotation or a reflection; columns are the axes of i, j, k
    space: str  #: that of NRRD in which positions are: 'left-posterior-superior' or 'right-anterior-superior'

    @property
    def grid(self) -> Grid:
        """In the image's frame, whose axes are those of the image, and whose origin is its first voxel."""
        return Grid((0, 0, 0), self.spacing, self.size)

    def to_frame(self, points: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
        """Positions (n, 3) in the image's frame."""
        return into_frame(points, self.direction, self.origin)  # type: ignore[no-any-return]

    def from_frame(self, vectors: npt.NDArray[Any], name: str = "closest") -> npt.NDArray[np.float64]:
        """Vectors (n, 3) of the frame in the image's space, or positions, if the name is 'closest'. Sums are written out:
        a product of matrices is another one on other processors."""
        x, y, z = vectors.astype(np.float64).T
        turned: npt.NDArray[np.float64] = np.stack([x * row[0] + y * row[1] + z * row[2] for row in self.direction], axis=1)
        return turned + self.origin if name == "closest" else turned

    def affine(self) -> npt.NDArray[np.float64]:
        """(4, 4), as nibabel has it: from (i, j, k) to the position in its space."""
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = self.direction * self.spacing, self.origin
        return np.diag([-1.0, -1, 1, 1]) @ matrix if self.space == _of_itk else matrix


def geometry_of(image: Any) -> Image:
    """The geometry of an image of SimpleITK or nibabel."""
    if isinstance(image, Image):
        return image
    if hasattr(image, "GetDirection") and hasattr(image, "GetSpacing"):
        size, direction = tuple(image.GetSize()), np.asarray(image.GetDirection(), np.float64)
        if len(size) != 3 or direction.size != 9:
            raise Error(f"image: it has {len(size)} dimensions, not 3")
        origin, spacing = np.asarray(image.GetOrigin(), np.float64), np.asarray(image.GetSpacing(), np.float64)
        return Image(origin, spacing, size, _orthogonal(direction.reshape(3, 3)), _of_itk)
    if hasattr(image, "affine") and hasattr(image, "shape"):
        size = tuple(int(side) for side in image.shape[:3])
        matrix = np.asarray(image.affine, np.float64)
        if len(size) != 3 or matrix.shape != (4, 4):
            raise Error(f"image: it has the shape {tuple(image.shape)} and an affine of the shape {matrix.shape}")
        spacing = np.linalg.norm(matrix[:3, :3], axis=0)
        if not (spacing > 0).all():
            raise Error("image: an axis of its affine has the length 0")
        return Image(matrix[:3, 3].copy(), spacing, size, _orthogonal(matrix[:3, :3] / spacing), _of_nifti)
    raise Error(f"image: a {type(image).__module__.partition('.')[0]}.{type(image).__qualname__} is no image of SimpleITK "
                "or nibabel")


def _orthogonal(direction: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """A direction that is orthogonal but for the rounding of files, made so in double."""
    error = np.abs(direction.T @ direction - np.eye(3)).max()
    if not error <= 1e-5:
        raise Error(f"image: its axes are not at right angles, by {error:.2g}; resample it to a grid whose axes are")
    if error <= 1e-14:
        return direction
    sign = float(np.sign(np.linalg.det(direction)))
    near: npt.NDArray[np.float64] = sign * np.array(_core.rotation_near((sign * direction).tolist()), np.float64)
    return near


def in_frame(image: Image, vertices: npt.NDArray[Any]) -> tuple[npt.NDArray[np.float64], int | None]:
    """The vertices in the image's frame, and the axis along which they are mirrored there (None: they are not): a mirrored
    mesh would be inside out."""
    local = image.to_frame(vertices)
    if np.linalg.det(image.direction) > 0:
        return local, None
    local[:, 0] = (image.size[0] - 1) * image.spacing[0] - local[:, 0]
    return local, 0


def finish(image: Image, arrays: dict[str, npt.NDArray[Any]], mirrored: int | None) -> None:
    """Turns vectors of the frame into those of the image's space, in place."""
    for name in ("gradient", "offset", "closest"):
        if name in arrays:
            rows = arrays[name].reshape(-1, 3)
            if mirrored is not None:
                rows[:, 0] = -rows[:, 0]
                if name == "closest":
                    rows[:, 0] += (image.size[0] - 1) * image.spacing[0]
            for begin in range(0, len(rows), 1 << 20):
                part = slice(begin, begin + (1 << 20))
                rows[part] = image.from_frame(rows[part], name)


def write(field: Samples, image: Image, path: str) -> None:
    """A .nrrd, .nii or .nii.gz of the distance, with the image's origin and direction."""
    ending = next((one for one in (".nrrd", ".nii.gz", ".nii") if path.lower().endswith(one)), None)
    if ending is None:
        raise Error(f"{path}: a field of an image is written as .nrrd, .nii or .nii.gz, which keep its direction", "unsupported")
    if field.outputs != ("distance",):
        raise Error(f"{path}: files of images store the distance alone, and this field has {', '.join(field.outputs)}",
                    "unsupported")
    write_image = _write_nrrd if ending == ".nrrd" else _write_nifti
    complete(path, ending, lambda unfinished: write_image(unfinished, field, image))


def _triple(numbers: Any) -> str:
    return "(" + ",".join(repr(float(number)) for number in numbers) + ")"


def _pairs(field: Samples) -> list[str]:
    """What the files of the library say of a field, in their words."""
    name = field.mesh_name.replace("\\", "\\\\").replace("\n", "\\n")
    said = {"version": _core.version(), "mesh": name, "sign": field.sign}
    if field.positive_inside:
        said["inside"] = "positive"
    said["band_inside"], said["band_outside"] = repr(field.band.inside), repr(field.band.outside)
    if field.band.exact_signs:
        said["band_signs"] = "exact"
    return [f"clsdf_{key}:={value}" for key, value in said.items()]


def _write_nrrd(path: str, field: Samples, image: Image) -> None:
    header = [
        "NRRD0005",
        f"# signed distance, {'positive' if field.positive_inside else 'negative'} inside; clsdf",
        "type: float",
        "dimension: 3",
        f"space: {image.space}",
        "sizes: " + " ".join(map(str, image.size)),
        "space directions: " + " ".join(map(_triple, (image.direction * image.spacing).T)),
        "kinds: domain domain domain",
        "endian: little",
        "encoding: raw",
        f"space origin: {_triple(image.origin)}",
        *_pairs(field),
    ]
    with open(path, "wb") as file:
        file.write(("\n".join(header) + "\n\n").encode())
        file.write(np.ascontiguousarray(field.distance, "<f4").data)


def _write_nifti(path: str, field: Samples, image: Image) -> None:
    import nibabel  # type: ignore[import-not-found,import-untyped,unused-ignore]

    voxels = np.asarray(field.distance, np.float32).transpose(2, 1, 0)
    make_image: Any = nibabel.Nifti1Image
    made = make_image(voxels, image.affine())
    made.header["descrip"] = f"signed distance, {'positive' if field.positive_inside else 'negative'} inside; clsdf"
    nibabel.save(made, path)
