from .phrases import listed as listed
from .phrases import phrase as phrase
from .phrases import topic as topic
from .sentences import asked as asked
from .sentences import indifference as indifference
from .sentences import meaning as meaning
from .sentences import why as why
