"""What the paper says, in short, where; and why ours differs, or what it rests on."""

from __future__ import annotations

from typing import NamedTuple


class Words(NamedTuple):
    """title: of the claim; where: the paper's section; words: the paper's; why: ours."""

    title: str
    where: str
    words: str
    why: str


def _one_line(title: str, where: str, words: str, why: str) -> Words:
    return Words(title, where, " ".join(words.split()), " ".join(why.split()))


WORDS = {
    "fig02": _one_line(
        "The route to the target",
        "2.1",
        """Normal and tangential force grow together until the object lifts at (mg/2μ, mg/2); people
        apply 1.2 to 1.5 times the least normal force.""",
        """The rule holds once the stick area has begun to fall; each hold raises F_n by a fixed
        step, and where in such a step the weight is reached is chance. So the margin varies from
        object to object (Fig. 10); nothing in the rule aims at a margin.""",
    ),
    "fig03": _one_line(
        "Rhomboids under stick",
        "2.2, 2.3",
        """Under shear the rectangles below the sticking surface are rhomboids, those below the
        slipping surface are not; so the change of shear strain over a short time tells stick from
        slip.""",
        """The shape itself does not tell: a slipping surface still carries μ times the pressure,
        which is largest just beside the stick zone, and the rubber below is sheared by it. What
        slip ends is the growth of that shear; close to the border the neighbours' shear reaches in
        as far as a rectangle is high. So the change over a short time (2.3) tells, the shape as
        drawn (2.2) does not.""",
    ),
    "fig07": _one_line(
        "Eight steps to complete slip",
        "3.1",
        """Open area decreases with the normal force, stick area decreases as the tangential force
        grows, from both edges; at the eighth step all slips. Stick area is large around step
        three.""",
        """The paper gives no displacements: the eight steps are those of the shipped scene, made so
        that the eighth slips on the paper's finger. The edges slip a little already when pressed
        alone: rubber that is pressed wants to spread.""",
    ),
    "likeness": _one_line(
        "Plates feel what rubber would shear",
        "3.1",
        """The normal strain of the plates' gages is similar to the shear strain of a homogeneous
        finger.""",
        """Similar in shape, by no means in size: a stiff plate hardly lets itself be strained. And
        only where both faces are read: one gage on one face feels the plate bend, which tells
        nothing of the shear. The paper does not say on which face its gages are.""",
    ),
    "fig08": _one_line(
        "The gage area follows the stick area",
        "3.1",
        """The change of the area where the change of strain per tangential force exceeds 40 is
        similar to that of the stick area; both are large around step three.""",
        """The paper's 40 has no unit and belongs to gages that we do not know: were it microstrain
        per newton, they would answer far more strongly than bronze plates do here. While F_n grows
        too, its own strain must be taken out first, which the paper does not mention.""",
    ),
    "fig08_relation": _one_line(
        "One relation for every friction",
        "3.1",
        """The relation of stick area and strain change was almost the same for all friction
        coefficients: it tells the stick area independent of the friction.""",
        """The error is that of the stick length told from A by the relation of the other frictions,
        RMS over the largest stick length; in brackets by the friction's own. Until complete slip
        the claim holds. Where the approach grows to the end, as in a grip, it fails at complete
        slip itself: F_t then changes with F_n alone, and A, made from that change, is as large as
        with half of the contact sticking. At μ = 0.2 the edges slip already under the press.""",
    ),
    "each_gage": _one_line(
        "Each gage tells of the surface near it",
        "2.3",
        """When the change of the shear strain at a point reaches a certain value, the surface near
        the point sticks; if not, it slips.""",
        """It is the depth. Close under the surface the rule nearly holds; as deep as the gages are,
        under a contact of a few millimetres, each feels the traction of all the surface around it,
        and so does rubber without plates there. One gage tells whether it lies near the contact,
        hardly more; what follows the stick area is the pattern of all gages, the area A. Thinner
        cover or a wider contact would sharpen it.""",
    ),
    "fig10": _one_line(
        "Lifts at unknown friction",
        "3.2",
        """For every friction coefficient the forces are controlled without complete slip; at μ =
        0.3 the slope is set to zero at F_n = 1.5 and 4.7.""",
        """The forces at which the rule holds follow from the finger, the steps and the curve, which
        the paper does not give. Our object is heavier than the paper's largest forces would lift,
        so that low friction is a test.""",
    ),
    "fig12": _one_line(
        "The measurement",
        "4.2",
        """Measured at μ = 0.3 and 0.6: controlled without complete slip and without excessive
        normal force.""",
        """Stiff plates answer by about one microstrain per newton, a good amplifier's noise is half
        a microstrain. Noise makes A fall by chance, and the rule hold: that is mostly safe, but the
        force at the lift then tells nothing of the friction. The paper's rig worked, so its gages
        presumably answered more strongly than bronze plates of this finger do. Softer plates
        answer more: polyimide, read on both faces, is drawn beside.""",
    ),
}
